#include <gtest/gtest.h>

#include "src/run/part.h"

namespace tessera {
namespace {

TEST(PartSpec, CrossesAWireUnchanged) {
  PartSpec spec;
  spec.run_folder = "out/.run";
  spec.out_folder = "out";
  spec.threads = 3;
  spec.memory_bytes = 1ull << 40;
  spec.kernel = KernelKind::cgal;
  spec.keep = Keep::reduced;
  spec.neighbors = false;
  spec.resumable = false;
  spec.grace_s = 300;
  spec.lock_file = "out/.lock/me";
  spec.table = {5, {{0}, {2}, {1}}, {0, 1, 7}};
  const auto back = spec_from_bytes(to_bytes(spec));
  ASSERT_TRUE(back);
  EXPECT_EQ(back.value(), spec);
  EXPECT_EQ(back.value().table.node_of(TileId{1}), NodeId{2});
}

TEST(PartSpec, WhatNoCoordinatorSendsIsRefused) {
  EXPECT_FALSE(spec_from_bytes("\xff\xff"));
  EXPECT_FALSE(spec_from_bytes(""));  // no threads
  PartSpec spec;
  spec.table.nodes = {{0}, {1}};  // without incarnations
  EXPECT_FALSE(spec_from_bytes(to_bytes(spec)));
}

}  // namespace
}  // namespace tessera
