// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/import_process.h"

#include <gtest/gtest.h>

#include <csignal>
#include <new>
#include <sys/resource.h>

#include "core/error.h"
#include "tests/mesh/samples.h"

namespace thermotwin {
namespace {

TEST(ImportProcess, TheMeshArrivesBitByBit) {
  mesh::TetMesh sent = samples::box_mesh({0.1, 0.2, 0.3}, 4);
  sent.groups["top"] = {1, 2, 3};
  sent.solids = 2;
  const mesh::TetMesh got = mesh::mesh_in_child("body", {}, [&] { return sent; });
  EXPECT_TRUE(got.points == sent.points && got.tets == sent.tets && got.faces == sent.faces);
  EXPECT_EQ(got.groups, sent.groups);
  EXPECT_EQ(got.solids, 2);
}

TEST(ImportProcess, ErrorsKeepTheirWordsAndType) {
  const auto message = [](const auto& fault) {
    return samples::message_of([&] {
      mesh::mesh_in_child("body", {}, [&]() -> mesh::TetMesh {
        fault();
        return {};
      });
    });
  };
  EXPECT_EQ(message([] { throw core::MeshError("body 'a': b.stl: line 3", "x: y", "z; or w"); }),
            "body 'a': b.stl: line 3: x: y; allowed: z; or w");
  EXPECT_THROW(mesh::mesh_in_child("body", {}, []() -> mesh::TetMesh { throw core::SolverError("diverged"); }),
               core::SolverError);
  EXPECT_THROW(mesh::mesh_in_child("body", {}, []() -> mesh::TetMesh { throw std::bad_alloc(); }), std::bad_alloc);
}

TEST(ImportProcess, TheLimitOfTimeFollowsTheSizeOfTheMesh) {
  const auto limit_in_child = [](double tetrahedra) {
    return samples::message_of([&] {
      mesh::mesh_in_child("body", {}, [&]() -> mesh::TetMesh {
        mesh::limit_time_by(tetrahedra);
        rlimit limit{};
        ::getrlimit(RLIMIT_CPU, &limit);
        throw core::MeshError("limit", std::to_string(limit.rlim_cur), "-");
      });
    });
  };
  EXPECT_NE(limit_in_child(2e4).find("limit: 320;"), std::string::npos) << limit_in_child(2e4);
  EXPECT_NE(limit_in_child(4e6).find("limit: 1200;"), std::string::npos) << limit_in_child(4e6);
  rlimit before{}, after{};
  ::getrlimit(RLIMIT_CPU, &before);
  mesh::limit_time_by(1.0);  // no child: its own limit stays
  ::getrlimit(RLIMIT_CPU, &after);
  EXPECT_EQ(before.rlim_cur, after.rlim_cur);
}

TEST(ImportProcess, ACrashAndALoopWithoutEndAreErrors) {
  const auto message = [](const auto& work) {
    return samples::message_of([&] { mesh::mesh_in_child("body 'a': b.step", {1.0, 0.0}, work); });
  };
  const std::string crash = message([]() -> mesh::TetMesh {
    std::signal(SIGSEGV, SIG_DFL);  // a sanitizer would end it with a status of its own
    std::raise(SIGSEGV);
    return {};
  });
  EXPECT_NE(crash.find("body 'a': b.step: reading or meshing it crashed"), std::string::npos) << crash;
  const std::string loop = message([]() -> mesh::TetMesh {
    for (volatile long i = 0;;) {
      const long next = i + 1;
      i = next;
    }
  });
  EXPECT_NE(loop.find("not read and meshed within 1 s of processor time"), std::string::npos) << loop;
  EXPECT_NE(loop.find("or mesher = \"lattice\" of the body"), std::string::npos) << loop;
}

}  // namespace
}  // namespace thermotwin
