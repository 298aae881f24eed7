// SPDX-License-Identifier: GPL-3.0-or-later
// The module that sees PETSc; see multigrid_levels.h. Nothing of it stays after a call but PETSc itself.
#include <petscksp.h>

#include <cstdlib>
#include <string>

#include "solver/linear/multigrid_levels.h"

namespace {

using thermotwin::solver::MultigridLevel;

void finish() {
  PetscBool running = PETSC_FALSE;
  PetscFinalized(&running);
  if (!running) PetscFinalize();
}

/// Without arguments, without PETSc's signal handlers; ends with the process.
PetscErrorCode start() {
  PetscBool running = PETSC_FALSE;
  PetscCall(PetscInitialized(&running));
  if (running) return 0;
  // The program runs by itself: MPI is not to look for networks.
  setenv("OMPI_MCA_btl", "self", 0);
  setenv("OMPI_MCA_pml", "ob1", 0);
  PetscCall(PetscOptionsSetValue(nullptr, "-no_signal_handler", "true"));
  PetscCall(PetscInitializeNoArguments());
  PetscCall(PetscPushErrorHandler(PetscIgnoreErrorHandler, nullptr));
  std::atexit(finish);
  return 0;
}

PetscErrorCode copy(Mat from, Eigen::SparseMatrix<double, Eigen::RowMajor>& to) {
  PetscInt rows = 0, columns = 0, count = 0;
  const PetscInt *outer = nullptr, *inner = nullptr;
  PetscBool done = PETSC_FALSE;
  const PetscScalar* values = nullptr;
  Mat plain = nullptr;
  PetscCall(MatConvert(from, MATSEQAIJ, MAT_INITIAL_MATRIX, &plain));
  PetscCall(MatGetSize(plain, &rows, &columns));
  PetscCall(MatGetRowIJ(plain, 0, PETSC_FALSE, PETSC_FALSE, &count, &outer, &inner, &done));
  PetscCheck(done, PETSC_COMM_SELF, PETSC_ERR_SUP, "no rows");
  PetscCall(MatSeqAIJGetArrayRead(plain, &values));
  to = Eigen::Map<const Eigen::SparseMatrix<double, Eigen::RowMajor>>(rows, columns, outer[rows], outer, inner, values);
  PetscCall(MatSeqAIJRestoreArrayRead(plain, &values));
  PetscCall(MatRestoreRowIJ(plain, 0, PETSC_FALSE, PETSC_FALSE, &count, &outer, &inner, &done));
  PetscCall(MatDestroy(&plain));
  return 0;
}

PetscErrorCode near_null_space(const Eigen::MatrixXd& modes, int block, MatNullSpace& space) {
  std::vector<Vec> vectors(modes.cols());
  // MatNullSpace wants them orthonormal.
  Eigen::MatrixXd basis = modes;
  for (Eigen::Index i = 0; i < basis.cols(); ++i) {
    for (int pass = 0; pass < 2; ++pass)
      for (Eigen::Index j = 0; j < i; ++j) basis.col(i) -= basis.col(j).dot(basis.col(i)) * basis.col(j);
    basis.col(i).normalize();
    Vec& vector = vectors[i];
    PetscCall(VecCreateSeq(PETSC_COMM_SELF, basis.rows(), &vector));
    PetscCall(VecSetBlockSize(vector, block));
    PetscScalar* values = nullptr;
    PetscCall(VecGetArray(vector, &values));
    Eigen::Map<Eigen::VectorXd>(values, basis.rows()) = basis.col(i);
    PetscCall(VecRestoreArray(vector, &values));
  }
  PetscCall(MatNullSpaceCreate(PETSC_COMM_SELF, PETSC_FALSE, vectors.size(), vectors.data(), &space));
  for (Vec& vector : vectors) PetscCall(VecDestroy(&vector));
  return 0;
}

PetscErrorCode build(const Eigen::SparseMatrix<double>& spd, int block, const Eigen::MatrixXd& near_null,
                     std::vector<MultigridLevel>& levels) {
  PetscCall(start());
  Mat matrix = nullptr;
  PetscCall(MatCreateSeqAIJWithArrays(PETSC_COMM_SELF, spd.rows(), spd.cols(), const_cast<int*>(spd.outerIndexPtr()),
                                      const_cast<int*>(spd.innerIndexPtr()), const_cast<double*>(spd.valuePtr()),
                                      &matrix));
  PetscCall(MatSetBlockSize(matrix, block));
  PetscCall(MatSetOption(matrix, MAT_SPD, PETSC_TRUE));
  if (near_null.cols() > 0) {
    MatNullSpace space = nullptr;
    PetscCall(near_null_space(near_null, block, space));
    PetscCall(MatSetNearNullSpace(matrix, space));
    PetscCall(MatNullSpaceDestroy(&space));
  }
  PC pc = nullptr;
  PetscCall(PCCreate(PETSC_COMM_SELF, &pc));
  PetscCall(PCSetOperators(pc, matrix, matrix));
  PetscCall(PCSetType(pc, PCGAMG));
  PetscCall(PCGAMGSetType(pc, PCGAMGAGG));
  PetscCall(PCGAMGSetAggressiveLevels(pc, 1));  // coarsens the finest level's graph squared
  PetscCall(PCSetFromOptions(pc));              // sets defaults that a plain set-up lacks
  PetscCall(PCSetUp(pc));
  PetscInt count = 0, coarse = 0, all = 0;
  Mat *prolongations = nullptr, *matrices = nullptr;
  PetscCall(PCGetInterpolations(pc, &count, &prolongations));
  PetscCall(PCGetCoarseOperators(pc, &coarse, &matrices));
  PetscCall(PCMGGetLevels(pc, &all));
  // Both count the finest level, for which they have nothing.
  PetscCheck(count == all && coarse == all, PETSC_COMM_SELF, PETSC_ERR_PLIB, "levels do not match");
  for (PetscInt l = all - 2; l >= 0; --l) {  // PETSc counts from the coarsest
    MultigridLevel level;
    PetscCall(copy(prolongations[l], level.prolongation));
    PetscCall(copy(matrices[l], level.matrix));
    levels.push_back(std::move(level));
    PetscCall(MatDestroy(&prolongations[l]));
    PetscCall(MatDestroy(&matrices[l]));
  }
  PetscCall(PetscFree(prolongations));
  PetscCall(PetscFree(matrices));
  PetscCall(PCDestroy(&pc));
  PetscCall(MatDestroy(&matrix));
  return 0;
}

}  // namespace

extern "C" bool thermotwin_multigrid_levels(const Eigen::SparseMatrix<double>& spd, int block,
                                            const Eigen::MatrixXd& near_null, std::vector<MultigridLevel>& levels,
                                            std::string& error) {
  const PetscErrorCode code = build(spd, block, near_null, levels);
  if (code == 0) return true;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  error = std::string("PETSc: ") + (text ? text : "unknown error");
  return false;
}
