// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/systems/sparse_lu.h"

#include <fmt/format.h>
#include <suitesparse/umfpack.h>

#include <vector>

#include "core/error.h"
#include "core/thread_pool.h"
#include "reduction/linear/lapack.h"

namespace thermotwin::reduction {

using core::SolverError;
using Complex = std::complex<double>;

namespace {

/// E and A on the union of their patterns.
struct Pencil {
  int n = 0;
  std::vector<int> outer, inner;
  std::vector<double> e, a;

  Pencil(const Sparse& e_in, const Sparse& a_in) : n(a_in.rows()) {
    // Sums keep entries that cancel: both have the union's pattern.
    const Sparse with_e = 1.0 * e_in + 0.0 * a_in, with_a = 0.0 * e_in + 1.0 * a_in;
    outer.assign(with_e.outerIndexPtr(), with_e.outerIndexPtr() + n + 1);
    inner.assign(with_e.innerIndexPtr(), with_e.innerIndexPtr() + with_e.nonZeros());
    e.assign(with_e.valuePtr(), with_e.valuePtr() + with_e.nonZeros());
    a.assign(with_a.valuePtr(), with_a.valuePtr() + with_a.nonZeros());
  }
  template <class Scalar>
  std::vector<Scalar> values(Scalar s) const {
    std::vector<Scalar> result(e.size());
    for (std::size_t k = 0; k < e.size(); ++k) result[k] = s * e[k] - a[k];
    return result;
  }
};

struct Settings {
  double control[UMFPACK_CONTROL];
  explicit Settings(bool complex_numbers) {
    complex_numbers ? umfpack_zi_defaults(control) : umfpack_di_defaults(control);
    control[UMFPACK_ORDERING] = UMFPACK_ORDERING_METIS;
    control[UMFPACK_IRSTEP] = 1;
  }
};

[[noreturn]] void fail(int status, int n, const char* what) {
  throw SolverError(
      fmt::format("sparse LU: {} of {} unknowns failed: {}", what, n,
                  status == UMFPACK_ERROR_out_of_memory ? "out of memory" : fmt::format("UMFPACK status {}", status)));
}

const double* as_reals(const std::vector<Complex>& values) { return reinterpret_cast<const double*>(values.data()); }

}  // namespace

struct PencilLu::Impl {
  Pencil pencil;
  void *real_analysis = nullptr, *complex_analysis = nullptr;

  Impl(const Sparse& e, const Sparse& a) : pencil(e, a) {
    const Settings real(false), complex_numbers(true);
    // A representative s: where entries of E and A are of like size.
    const double size = core_ratio();
    const std::vector<double> values = pencil.values(size);
    const std::vector<Complex> complex_values = pencil.values(Complex(0, size));
    int status = umfpack_di_symbolic(pencil.n, pencil.n, pencil.outer.data(), pencil.inner.data(), values.data(),
                                     &real_analysis, real.control, nullptr);
    if (status < 0) fail(status, pencil.n, "the analysis");
    status = umfpack_zi_symbolic(pencil.n, pencil.n, pencil.outer.data(), pencil.inner.data(), as_reals(complex_values),
                                 nullptr, &complex_analysis, complex_numbers.control, nullptr);
    if (status < 0) fail(status, pencil.n, "the analysis");
  }
  ~Impl() {
    umfpack_di_free_symbolic(&real_analysis);
    umfpack_zi_free_symbolic(&complex_analysis);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  double core_ratio() const {
    double of_e = 0, of_a = 0;
    for (std::size_t k = 0; k < pencil.e.size(); ++k) {
      of_e += std::abs(pencil.e[k]);
      of_a += std::abs(pencil.a[k]);
    }
    return of_e > 0.0 && of_a > 0.0 ? of_a / of_e : 1.0;
  }
};

struct PencilLu::Factor::Impl {
  Complex s;
  const Pencil* pencil = nullptr;
  std::vector<double> real_values;
  std::vector<Complex> complex_values;
  void *real = nullptr, *complex_numbers = nullptr;
  double rcond = 0;

  ~Impl() {
    if (real) umfpack_di_free_numeric(&real);
    if (complex_numbers) umfpack_zi_free_numeric(&complex_numbers);
  }
};

PencilLu::PencilLu(const Sparse& e, const Sparse& a) : impl_(std::make_unique<Impl>(e, a)) {
  lapack::use_one_blas_thread();
}
PencilLu::~PencilLu() = default;

PencilLu::Factor::Factor(Complex s) : impl_(std::make_unique<Impl>()) { impl_->s = s; }
PencilLu::Factor::~Factor() = default;
PencilLu::Factor::Factor(Factor&&) noexcept = default;
double PencilLu::Factor::rcond() const { return impl_->rcond; }

PencilLu::Factor PencilLu::factorise(Complex s) const {
  Factor factor(s);
  Factor::Impl& to = *factor.impl_;
  const Pencil& pencil = impl_->pencil;
  to.pencil = &pencil;
  double info[UMFPACK_INFO];
  int status = 0;
  if (s.imag() == 0.0) {
    const Settings settings(false);
    to.real_values = pencil.values(s.real());
    status = umfpack_di_numeric(pencil.outer.data(), pencil.inner.data(), to.real_values.data(), impl_->real_analysis,
                                &to.real, settings.control, info);
  } else {
    const Settings settings(true);
    to.complex_values = pencil.values(s);
    status = umfpack_zi_numeric(pencil.outer.data(), pencil.inner.data(), as_reals(to.complex_values), nullptr,
                                impl_->complex_analysis, &to.complex_numbers, settings.control, info);
  }
  if (status < 0) fail(status, pencil.n, "the factorisation");
  to.rcond = status == UMFPACK_WARNING_singular_matrix ? 0.0 : info[UMFPACK_RCOND];
  return factor;
}

Eigen::MatrixXd PencilLu::Factor::solve(const Eigen::MatrixXd& b, bool transposed) const {
  const Pencil& pencil = *impl_->pencil;
  Eigen::MatrixXd x(b.rows(), b.cols());
  core::parallel_for(0, b.cols(), [&](std::size_t column) {
    const Eigen::Index j = column;
    const Settings settings(false);
    const int status = umfpack_di_solve(transposed ? UMFPACK_Aat : UMFPACK_A, pencil.outer.data(), pencil.inner.data(),
                                        impl_->real_values.data(), x.col(j).data(), b.col(j).data(), impl_->real,
                                        settings.control, nullptr);
    if (status < 0) fail(status, pencil.n, "a solve");
  });
  return x;
}

Eigen::MatrixXcd PencilLu::Factor::solve(const Eigen::MatrixXcd& b, bool transposed) const {
  if (impl_->s.imag() == 0.0) {
    const Eigen::MatrixXd real = solve(Eigen::MatrixXd(b.real()), transposed);
    if (b.imag().isZero(0.0)) return real.cast<Complex>();
    const Eigen::MatrixXd imaginary = solve(Eigen::MatrixXd(b.imag()), transposed);
    return real.cast<Complex>() + Complex(0, 1) * imaginary.cast<Complex>();
  }
  const Pencil& pencil = *impl_->pencil;
  Eigen::MatrixXcd x(b.rows(), b.cols());
  core::parallel_for(0, b.cols(), [&](std::size_t column) {
    const Eigen::Index j = column;
    const Settings settings(true);
    const int status = umfpack_zi_solve(
        transposed ? UMFPACK_Aat : UMFPACK_A, pencil.outer.data(), pencil.inner.data(), as_reals(impl_->complex_values),
        nullptr, reinterpret_cast<double*>(x.col(j).data()), nullptr, reinterpret_cast<const double*>(b.col(j).data()),
        nullptr, impl_->complex_numbers, settings.control, nullptr);
    if (status < 0) fail(status, pencil.n, "a solve");
  });
  return x;
}

}  // namespace thermotwin::reduction
