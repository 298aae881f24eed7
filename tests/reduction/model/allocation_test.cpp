// SPDX-License-Identifier: GPL-3.0-or-later
// A step in a control must not wait for memory. glibc's malloc is counted, since Eigen calls it
// directly; sanitizers bring a malloc of their own and leave this out.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#include "reduction/model/exact_stepper.h"
#include "tests/reduction/random_system.h"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {
std::atomic<long> allocations{0};
}

extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) noexcept {
  ++allocations;
  return __libc_malloc(size);
}

namespace thermotwin::reduction {
namespace {

using Eigen::VectorXd;
using test::random_coefficients;
using test::random_system;

TEST(ReducedStepper, AllocationsAreCounted) {
  const long before = allocations;
  const VectorXd vector = VectorXd::Ones(1000);
  EXPECT_GT(allocations, before) << vector(0);
}

TEST(ReducedStepper, NothingIsAllocatedAfterTheFirstCall) {
  const ReducedSystem system = random_system(160, 40, 30, 26);
  solver::Coefficients c = random_coefficients(system, 27);
  ReducedStepper stepper(system);
  VectorXd state = VectorXd::Ones(160);
  stepper.advance(state, c, 60.0);
  c.p(3) *= 1.01;
  const long before = allocations;
  stepper.advance(state, c, 60.0);  // refined, then a factor of its own
  for (int i = 0; i < 10; ++i) stepper.advance(state, c, 60.0);
  const long after = allocations;
  EXPECT_EQ(after - before, 0);
}

TEST(ExactStepper, NothingIsAllocatedOnceItsLadderStands) {
  const ReducedSystem system = random_system(60, 20, 30, 28);
  const solver::Coefficients c = random_coefficients(system, 29);
  ExactStepper stepper(system);
  VectorXd state = VectorXd::Ones(60);
  for (int i = 0; i < 3; ++i) stepper.advance(state, c, 60.0);
  const long before = allocations;
  for (int i = 0; i < 10; ++i) stepper.advance(state, c, 60.0 - i);
  const long after = allocations;
  EXPECT_EQ(after - before, 0);
  EXPECT_EQ(stepper.statistics().passed, 1);
}

}  // namespace
}  // namespace thermotwin::reduction

#endif
