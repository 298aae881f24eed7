// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
/// Loops inside of Eigen's products, triangular solves and decompositions, compiled once (matrix_kernels.cpp) instead
/// of in each source that multiplies matrices. Part of cmake/precompiled.h; results do not depend on it.

#include <Eigen/Dense>
#include <Eigen/SparseCore>

#include <complex>

namespace thermotwin::core::kernels {

using Matrix = Eigen::MatrixXd;
using Panel = Eigen::Block<Matrix>;
using Sparse = Eigen::SparseMatrix<double>;
using Coefficients = Eigen::VectorBlock<const Eigen::VectorXd>;
using CoefficientBlock = Eigen::Block<const Eigen::VectorXd, Eigen::Dynamic, 1>;

template <class Scalar, int order>
using In = Eigen::internal::const_blas_data_mapper<Scalar, Eigen::Index, order>;
template <class Scalar>
using InColumns = In<Scalar, Eigen::ColMajor>;
template <class Scalar>
using InRows = In<Scalar, Eigen::RowMajor>;
template <class Scalar>
using Out = Eigen::internal::blas_data_mapper<Scalar, Eigen::Index, Eigen::ColMajor, Eigen::Unaligned, 1>;
template <class Left, class Right>
using Traits = Eigen::internal::gebp_traits<Left, Right>;
template <class Left, class Right>
using Result = Out<typename Traits<Left, Right>::ResScalar>;

}  // namespace thermotwin::core::kernels

// An alias cannot be instantiated, so that Eigen's classes stand in macros.
#define THERMOTWIN_KERNELS thermotwin::core::kernels
#define THERMOTWIN_TRAITS(L, R) THERMOTWIN_KERNELS::Traits<L, R>
/// The innermost loop of a product. @param CL, CR  whether the left, the right factor is conjugated
#define THERMOTWIN_BLOCK(L, R, CL, CR)                                                      \
  struct Eigen::internal::gebp_kernel<L, R, Eigen::Index, THERMOTWIN_KERNELS::Result<L, R>, \
                                      THERMOTWIN_TRAITS(L, R)::mr, THERMOTWIN_TRAITS(L, R)::nr, CL, CR>
#define THERMOTWIN_PACK_LEFT(L, R, MAPPER, ORDER, PANEL)                                      \
  struct Eigen::internal::gemm_pack_lhs<L, Eigen::Index, MAPPER, THERMOTWIN_TRAITS(L, R)::mr, \
                                        THERMOTWIN_TRAITS(L, R)::LhsProgress,                 \
                                        THERMOTWIN_TRAITS(L, R)::LhsPacket4Packing, ORDER, false, PANEL>
#define THERMOTWIN_PACK_RIGHT(L, R, MAPPER, ORDER, PANEL) \
  struct Eigen::internal::gemm_pack_rhs<R, Eigen::Index, MAPPER, THERMOTWIN_TRAITS(L, R)::nr, ORDER, false, PANEL>
#define THERMOTWIN_PRODUCT(L, LEFT, R, RIGHT)                                                          \
  struct Eigen::internal::general_matrix_matrix_product<Eigen::Index, L, LEFT, false, R, RIGHT, false, \
                                                        Eigen::ColMajor, 1>
/// Matrix times vector. @param VERSION  of Eigen: 1 inside of triangular products
#define THERMOTWIN_VECTOR(L, ORDER, CL, R, RIGHT, CR, VERSION)                                                        \
  struct Eigen::internal::general_matrix_vector_product<Eigen::Index, L, THERMOTWIN_KERNELS::In<L, ORDER>, ORDER, CL, \
                                                        R, THERMOTWIN_KERNELS::In<R, RIGHT>, CR, VERSION>
#define THERMOTWIN_SOLVE(SIDE, MODE, ORDER)                                                                     \
  struct Eigen::internal::triangular_solve_matrix<double, Eigen::Index, Eigen::SIDE, Eigen::MODE, false, ORDER, \
                                                  Eigen::ColMajor, 1>
#define THERMOTWIN_SOLVE_VECTOR(MODE, ORDER)                                                                          \
  struct Eigen::internal::triangular_solve_vector<double, double, Eigen::Index, Eigen::OnTheLeft, Eigen::MODE, false, \
                                                  ORDER>

/// DO(class or function) for each kernel that several sources use.
#define THERMOTWIN_EACH_KERNEL(DO)                                                                                     \
  DO(THERMOTWIN_BLOCK(double, double, false, false))                                                                   \
  DO(THERMOTWIN_BLOCK(double, std::complex<double>, false, false))                                                     \
  DO(THERMOTWIN_BLOCK(std::complex<double>, double, false, false))                                                     \
  DO(THERMOTWIN_BLOCK(std::complex<double>, std::complex<double>, false, false))                                       \
  DO(THERMOTWIN_BLOCK(std::complex<double>, std::complex<double>, true, false))                                        \
  DO(THERMOTWIN_PACK_LEFT(double, double, THERMOTWIN_KERNELS::InColumns<double>, Eigen::ColMajor, false))              \
  DO(THERMOTWIN_PACK_RIGHT(double, double, THERMOTWIN_KERNELS::InColumns<double>, Eigen::ColMajor, false))             \
  DO(THERMOTWIN_PACK_LEFT(double, std::complex<double>, THERMOTWIN_KERNELS::InColumns<double>, Eigen::ColMajor,        \
                          false))                                                                                      \
  DO(THERMOTWIN_PACK_RIGHT(double, std::complex<double>, THERMOTWIN_KERNELS::InColumns<std::complex<double>>,          \
                           Eigen::ColMajor, false))                                                                    \
  DO(THERMOTWIN_PACK_LEFT(double, double, THERMOTWIN_KERNELS::InRows<double>, Eigen::RowMajor, false))                 \
  DO(THERMOTWIN_PACK_RIGHT(double, double, THERMOTWIN_KERNELS::InRows<double>, Eigen::RowMajor, false))                \
  DO(THERMOTWIN_PACK_LEFT(double, std::complex<double>, THERMOTWIN_KERNELS::InRows<double>, Eigen::RowMajor, false))   \
  DO(THERMOTWIN_PACK_RIGHT(double, std::complex<double>, THERMOTWIN_KERNELS::InRows<std::complex<double>>,             \
                           Eigen::RowMajor, false))                                                                    \
  DO(THERMOTWIN_PACK_LEFT(double, double, THERMOTWIN_KERNELS::Out<double>, Eigen::ColMajor, true))                     \
  DO(THERMOTWIN_PACK_RIGHT(double, double, THERMOTWIN_KERNELS::Out<double>, Eigen::ColMajor, true))                    \
  DO(THERMOTWIN_PACK_RIGHT(double, double, THERMOTWIN_KERNELS::InRows<double>, Eigen::RowMajor, true))                 \
  DO(THERMOTWIN_PRODUCT(double, Eigen::ColMajor, double, Eigen::ColMajor))                                             \
  DO(THERMOTWIN_PRODUCT(double, Eigen::ColMajor, double, Eigen::RowMajor))                                             \
  DO(THERMOTWIN_PRODUCT(double, Eigen::RowMajor, double, Eigen::ColMajor))                                             \
  DO(THERMOTWIN_PRODUCT(double, Eigen::RowMajor, double, Eigen::RowMajor))                                             \
  DO(THERMOTWIN_PRODUCT(double, Eigen::ColMajor, std::complex<double>, Eigen::ColMajor))                               \
  DO(THERMOTWIN_PRODUCT(std::complex<double>, Eigen::ColMajor, std::complex<double>, Eigen::ColMajor))                 \
  DO(THERMOTWIN_VECTOR(double, Eigen::RowMajor, false, double, Eigen::ColMajor, false, 0))                             \
  DO(THERMOTWIN_VECTOR(double, Eigen::ColMajor, false, double, Eigen::RowMajor, false, 0))                             \
  DO(THERMOTWIN_VECTOR(double, Eigen::ColMajor, false, double, Eigen::ColMajor, false, 0))                             \
  DO(THERMOTWIN_VECTOR(double, Eigen::RowMajor, false, double, Eigen::RowMajor, false, 1))                             \
  DO(THERMOTWIN_VECTOR(std::complex<double>, Eigen::RowMajor, false, double, Eigen::ColMajor, false, 0))               \
  DO(THERMOTWIN_VECTOR(double, Eigen::RowMajor, false, std::complex<double>, Eigen::ColMajor, false, 0))               \
  DO(THERMOTWIN_VECTOR(double, Eigen::ColMajor, false, std::complex<double>, Eigen::RowMajor, false, 0))               \
  DO(THERMOTWIN_VECTOR(std::complex<double>, Eigen::RowMajor, false, std::complex<double>, Eigen::ColMajor, false, 0)) \
  DO(THERMOTWIN_VECTOR(std::complex<double>, Eigen::ColMajor, false, std::complex<double>, Eigen::RowMajor, false, 0)) \
  DO(THERMOTWIN_VECTOR(std::complex<double>, Eigen::RowMajor, true, std::complex<double>, Eigen::ColMajor, false, 0))  \
  DO(THERMOTWIN_VECTOR(std::complex<double>, Eigen::RowMajor, false, std::complex<double>, Eigen::ColMajor, true, 0))  \
  DO(THERMOTWIN_SOLVE(OnTheLeft, UnitLower, Eigen::ColMajor))                                                          \
  DO(THERMOTWIN_SOLVE(OnTheLeft, Upper, Eigen::ColMajor))                                                              \
  DO(THERMOTWIN_SOLVE(OnTheLeft, Lower, Eigen::ColMajor))                                                              \
  DO(THERMOTWIN_SOLVE(OnTheLeft, UnitUpper, Eigen::RowMajor))                                                          \
  DO(THERMOTWIN_SOLVE(OnTheLeft, Upper, Eigen::RowMajor))                                                              \
  DO(THERMOTWIN_SOLVE(OnTheRight, Upper, Eigen::RowMajor))                                                             \
  DO(THERMOTWIN_SOLVE_VECTOR(UnitLower, Eigen::ColMajor))                                                              \
  DO(THERMOTWIN_SOLVE_VECTOR(Upper, Eigen::ColMajor))                                                                  \
  DO(THERMOTWIN_SOLVE_VECTOR(Lower, Eigen::ColMajor))                                                                  \
  DO(THERMOTWIN_SOLVE_VECTOR(Upper, Eigen::RowMajor))                                                                  \
  DO(THERMOTWIN_SOLVE_VECTOR(Lower, Eigen::RowMajor))                                                                  \
  DO(THERMOTWIN_SOLVE_VECTOR(UnitUpper, Eigen::RowMajor))                                                              \
  DO(void Eigen::internal::apply_block_householder_on_the_left(                                                        \
      THERMOTWIN_KERNELS::Panel&, const THERMOTWIN_KERNELS::Panel&, const THERMOTWIN_KERNELS::Coefficients&, bool))    \
  DO(void Eigen::internal::apply_block_householder_on_the_left(THERMOTWIN_KERNELS::Panel&,                             \
                                                               const THERMOTWIN_KERNELS::Panel&,                       \
                                                               const THERMOTWIN_KERNELS::CoefficientBlock&, bool))     \
  DO(Eigen::Index Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked(THERMOTWIN_KERNELS::Matrix&))            \
  DO(void Eigen::internal::assign_sparse_to_sparse(THERMOTWIN_KERNELS::Sparse&, const THERMOTWIN_KERNELS::Sparse&))    \
  DO(double Eigen::internal::rcond_invmatrix_L1_norm_estimate(const Eigen::LLT<THERMOTWIN_KERNELS::Matrix>&))          \
  DO(double Eigen::internal::rcond_invmatrix_L1_norm_estimate(const Eigen::PartialPivLU<THERMOTWIN_KERNELS::Matrix>&)) \
  DO(Eigen::PartialPivLU<THERMOTWIN_KERNELS::Matrix>::PartialPivLU(                                                    \
      const Eigen::EigenBase<THERMOTWIN_KERNELS::Matrix>&))                                                            \
  DO(Eigen::LLT<THERMOTWIN_KERNELS::Matrix>& Eigen::LLT<THERMOTWIN_KERNELS::Matrix>::compute(                          \
      const Eigen::EigenBase<THERMOTWIN_KERNELS::Matrix>&))                                                            \
  DO(Eigen::LDLT<THERMOTWIN_KERNELS::Matrix>& Eigen::LDLT<THERMOTWIN_KERNELS::Matrix>::compute(                        \
      const Eigen::EigenBase<THERMOTWIN_KERNELS::Matrix>&))                                                            \
  DO(class Eigen::CompleteOrthogonalDecomposition<THERMOTWIN_KERNELS::Matrix>)

#define THERMOTWIN_COMPILED_ELSEWHERE(...) extern template __VA_ARGS__;
THERMOTWIN_EACH_KERNEL(THERMOTWIN_COMPILED_ELSEWHERE)
#undef THERMOTWIN_COMPILED_ELSEWHERE
