// SPDX-License-Identifier: GPL-3.0-or-later
#include "reduction/linear/lapack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <dlfcn.h>
#include <thread>
#include <vector>

#include "core/blas_buffers.h"
#include "core/error.h"

extern "C" {
using thermotwin_complex = std::complex<double>;
void dgees_(const char*, const char*, int (*)(const double*, const double*), const int*, double*, const int*, int*,
            double*, double*, double*, const int*, double*, const int*, int*, int*);
void dsygvd_(const int*, const char*, const char*, const int*, double*, const int*, double*, const int*, double*,
             double*, const int*, int*, const int*, int*);
void dsyevd_(const char*, const char*, const int*, double*, const int*, double*, double*, const int*, int*, const int*,
             int*);
void zheev_(const char*, const char*, const int*, thermotwin_complex*, const int*, double*, thermotwin_complex*,
            const int*, double*, int*);
void dpstrf_(const char*, const int*, double*, const int*, int*, int*, const double*, double*, int*);
void dgesdd_(const char*, const int*, const int*, double*, const int*, double*, double*, const int*, double*,
             const int*, double*, const int*, int*, int*);
void dgeqrf_(const int*, const int*, double*, const int*, double*, double*, const int*, int*);
void dgebal_(const char*, const int*, double*, const int*, int*, int*, double*, int*);
void dgemm_(const char*, const char*, const int*, const int*, const int*, const double*, const double*, const int*,
            const double*, const int*, const double*, double*, const int*);
void zgemm_(const char*, const char*, const int*, const int*, const int*, const thermotwin_complex*,
            const thermotwin_complex*, const int*, const thermotwin_complex*, const int*, const thermotwin_complex*,
            thermotwin_complex*, const int*);
}

namespace thermotwin::reduction::lapack {
namespace {

using core::SolverError;
using Complex = std::complex<double>;
using Eigen::Index;

int extent(Index n) { return n; }

void set_blas_threads(int count) {
  using Setter = void (*)(int);
  static const auto setter = reinterpret_cast<Setter>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  core::reserve_blas_buffers();
  if (setter) setter(count);
}

/// All cores while this lives, for matrices large enough to gain from it on a machine that others use
/// too: threads of the BLAS wait for each other without sleeping.
class ManyCores {
public:
  explicit ManyCores(Index n) {
    constexpr Index worthwhile = 1500;
    set_blas_threads(n >= worthwhile ? std::max(1U, std::thread::hardware_concurrency()) : 1);
  }
  /// For a product of (m x k) and (k x n).
  ManyCores(Index m, Index n, Index k) : ManyCores(static_cast<Index>(std::cbrt(1.0 * m * n * k))) {}
  ~ManyCores() { set_blas_threads(1); }
  ManyCores(const ManyCores&) = delete;
  ManyCores& operator=(const ManyCores&) = delete;
};

/// Room that LAPACK asks for in the first entry of its work.
int asked_size(const std::vector<double>& work) { return static_cast<int>(work[0]); }

void require(int info, const char* what, Index n) {
  if (info != 0)
    throw SolverError(fmt::format("{} of a dense matrix of {} rows did not converge (LAPACK says {})", what, n, info));
}

/// 2 x 2 blocks of a real Schur form made triangular by unitary rotations.
void triangularise(Schur& schur) {
  MatrixXcd& t = schur.triangular;
  const Index n = t.rows();
  for (Index k = 0; k + 1 < n; ++k) {
    if (t(k + 1, k) == 0.0) continue;
    const Complex a = t(k, k), b = t(k, k + 1), c = t(k + 1, k), d = t(k + 1, k + 1);
    // LAPACK's blocks have equal diagonals and b c < 0.
    const Complex half = 0.5 * (a - d), root = std::sqrt(half * half + b * c);
    const Complex value = 0.5 * (a + d) + root;
    Complex x = b, y = value - a;
    if (std::abs(x) + std::abs(y) == 0.0) x = value - d, y = c;
    const double length = std::hypot(std::abs(x), std::abs(y));
    Eigen::Matrix2cd rotation;
    x /= length;
    y /= length;
    rotation << x, -std::conj(y), y, std::conj(x);
    t.middleCols(k, 2).topRows(k + 2) = (t.middleCols(k, 2).topRows(k + 2) * rotation).eval();
    t.middleRows(k, 2).rightCols(n - k) = (rotation.adjoint() * t.middleRows(k, 2).rightCols(n - k)).eval();
    schur.vectors.middleCols(k, 2) = (schur.vectors.middleCols(k, 2) * rotation).eval();
    t(k + 1, k) = 0.0;
  }
}

}  // namespace

Schur schur(MatrixXd matrix) {
  const ManyCores cores(matrix.rows());
  const int n = extent(matrix.rows());
  MatrixXd vectors(n, n);
  std::vector<double> real(matrix.rows()), imaginary(matrix.rows()), work(1);
  int found = 0, info = 0, size = -1;
  dgees_("V", "N", nullptr, &n, matrix.data(), &n, &found, real.data(), imaginary.data(), vectors.data(), &n,
         work.data(), &size, nullptr, &info);
  size = asked_size(work);
  work.resize(size);
  dgees_("V", "N", nullptr, &n, matrix.data(), &n, &found, real.data(), imaginary.data(), vectors.data(), &n,
         work.data(), &size, nullptr, &info);
  require(info, "the Schur form", n);
  Schur result{matrix.cast<Complex>(), vectors.cast<Complex>()};
  triangularise(result);
  return result;
}

std::optional<SymmetricPair> symmetric_pair(MatrixXd matrix, MatrixXd metric) {
  const ManyCores cores(matrix.rows());
  const int n = extent(matrix.rows()), kind = 1;
  SymmetricPair result;
  result.values.resize(n);
  std::vector<double> work(1);
  std::vector<int> integers(1);
  int info = 0, size = -1, integer_size = -1;
  dsygvd_(&kind, "V", "L", &n, matrix.data(), &n, metric.data(), &n, result.values.data(), work.data(), &size,
          integers.data(), &integer_size, &info);
  size = asked_size(work);
  integer_size = integers[0];
  work.resize(size);
  integers.resize(integer_size);
  dsygvd_(&kind, "V", "L", &n, matrix.data(), &n, metric.data(), &n, result.values.data(), work.data(), &size,
          integers.data(), &integer_size, &info);
  if (info > n) return std::nullopt;
  require(info, "the symmetric eigenproblem", n);
  result.vectors = std::move(matrix);
  return result;
}

SymmetricPair symmetric_eigen(MatrixXd matrix) {
  const ManyCores cores(matrix.rows());
  const int n = extent(matrix.rows());
  SymmetricPair result;
  result.values.resize(n);
  std::vector<double> work(1);
  std::vector<int> integers(1);
  int info = 0, size = -1, integer_size = -1;
  dsyevd_("V", "L", &n, matrix.data(), &n, result.values.data(), work.data(), &size, integers.data(), &integer_size,
          &info);
  size = asked_size(work);
  integer_size = integers[0];
  work.resize(size);
  integers.resize(integer_size);
  dsyevd_("V", "L", &n, matrix.data(), &n, result.values.data(), work.data(), &size, integers.data(), &integer_size,
          &info);
  require(info, "the symmetric eigenproblem", n);
  result.vectors = std::move(matrix);
  return result;
}

double largest_eigenvalue(MatrixXcd matrix) {
  const int n = extent(matrix.rows()), size = 2 * n;
  Eigen::VectorXd values(n), real_work(3 * n);
  Eigen::VectorXcd work(size);
  int info = 0;
  zheev_("N", "L", &n, matrix.data(), &n, values.data(), work.data(), &size, real_work.data(), &info);
  require(info, "the Hermitian eigenproblem", n);
  return values(n - 1);
}

MatrixXd pivoted_cholesky(MatrixXd matrix, double least) {
  if (matrix.size() == 0) return matrix;
  const ManyCores cores(matrix.rows());
  const int n = extent(matrix.rows());
  const double stop = least * matrix.diagonal().maxCoeff();
  if (!(stop > 0.0)) return MatrixXd(n, 0);
  std::vector<int> pivots(n);
  std::vector<double> work(2 * n);
  int rank = 0, info = 0;
  dpstrf_("L", &n, matrix.data(), &n, pivots.data(), &rank, &stop, work.data(), &info);
  if (info < 0) require(info, "the pivoted Cholesky factorisation", n);
  MatrixXd factor(n, rank);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < rank; ++j) factor(pivots[i] - 1, j) = j <= i ? matrix(i, j) : 0.0;
  return factor;
}

Svd svd(MatrixXd matrix) {
  const int m = extent(matrix.rows()), n = extent(matrix.cols()), k = std::min(m, n);
  const ManyCores cores(k);
  Svd result{MatrixXd(m, k), MatrixXd(), Eigen::VectorXd(k)};
  MatrixXd right(k, n);
  std::vector<double> work(1);
  std::vector<int> integers(8 * std::max(k, 1));
  int info = 0, size = -1;
  dgesdd_("S", &m, &n, matrix.data(), &m, result.values.data(), result.left.data(), &m, right.data(), &k, work.data(),
          &size, integers.data(), &info);
  size = asked_size(work);
  work.resize(size);
  dgesdd_("S", &m, &n, matrix.data(), &m, result.values.data(), result.left.data(), &m, right.data(), &k, work.data(),
          &size, integers.data(), &info);
  require(info, "the singular value decomposition", m);
  result.right = right.transpose();
  return result;
}

MatrixXd triangle_of_qr(MatrixXd matrix) {
  const int m = extent(matrix.rows()), n = extent(matrix.cols());
  const ManyCores cores(n);
  std::vector<double> tau(n), work(1);
  int info = 0, size = -1;
  dgeqrf_(&m, &n, matrix.data(), &m, tau.data(), work.data(), &size, &info);
  size = asked_size(work);
  work.resize(size);
  dgeqrf_(&m, &n, matrix.data(), &m, tau.data(), work.data(), &size, &info);
  require(info, "the QR factorisation", m);
  return matrix.topRows(n).triangularView<Eigen::Upper>();
}

MatrixXd product(const MatrixXd& a, const MatrixXd& b) {
  const int m = extent(a.rows()), n = extent(b.cols()), k = extent(a.cols());
  const ManyCores cores(m, n, k);
  MatrixXd c(m, n);
  const double one = 1, zero = 0;
  dgemm_("N", "N", &m, &n, &k, &one, a.data(), &m, b.data(), &k, &zero, c.data(), &m);
  return c;
}

void subtract_product(const Eigen::Ref<const MatrixXd>& a, const MatrixXd& b, MatrixXd& c) {
  const int m = extent(a.rows()), n = extent(b.cols()), k = extent(a.cols());
  const int a_stride = extent(a.outerStride());
  const ManyCores cores(m, n, k);
  const double minus_one = -1, one = 1;
  dgemm_("N", "N", &m, &n, &k, &minus_one, a.data(), &a_stride, b.data(), &k, &one, c.data(), &m);
}

void transposed_product(const Eigen::Ref<const MatrixXd>& a, const Eigen::Ref<const MatrixXd>& b,
                        Eigen::Ref<MatrixXd> c) {
  const int m = extent(a.cols()), n = extent(b.cols()), k = extent(a.rows());
  const int a_stride = extent(a.outerStride()), b_stride = extent(b.outerStride()), c_stride = extent(c.outerStride());
  const ManyCores cores(m, n, k);
  const double one = 1, zero = 0;
  dgemm_("T", "N", &m, &n, &k, &one, a.data(), &a_stride, b.data(), &b_stride, &zero, c.data(), &c_stride);
}

MatrixXcd product(const MatrixXcd& a, const MatrixXcd& b) {
  const int m = extent(a.rows()), n = extent(b.cols()), k = extent(a.cols());
  const ManyCores cores(m, n, k);
  MatrixXcd c(m, n);
  const Complex one = 1, zero = 0;
  zgemm_("N", "N", &m, &n, &k, &one, a.data(), &m, b.data(), &k, &zero, c.data(), &m);
  return c;
}

Eigen::VectorXd balance(MatrixXd& matrix) {
  const int n = extent(matrix.rows());
  Eigen::VectorXd scale(n);
  int low = 0, high = 0, info = 0;
  dgebal_("S", &n, matrix.data(), &n, &low, &high, scale.data(), &info);
  require(info, "balancing", n);
  return scale;
}

void use_one_blas_thread() { set_blas_threads(1); }

}  // namespace thermotwin::reduction::lapack
