#include <gtest/gtest.h>

#include <string>

#include "src/delaunay/run/run_options.h"

namespace tessera {
namespace {

TEST(ShareSpec, CrossesAWireUnchanged) {
  ShareSpec spec;
  spec.run_folder = "out/.run";
  spec.out_folder = "out";
  spec.threads = 3;
  spec.memory_bytes = 1ull << 40;
  spec.programs = std::string("\0 any", 5);
  spec.resumable = false;
  spec.grace_s = 300;
  spec.lock_file = "out/.lock/me";
  spec.table = {{Term{4}, 5}, 2, {{0}, {2}, {1}}, {Incarnation(), {{}, 1}, {Term{3}, 7}}};
  const auto back = spec_from_bytes(to_bytes(spec));
  ASSERT_TRUE(back);
  EXPECT_EQ(back.value(), spec);
  EXPECT_EQ(back.value().table.node_of(TileId{1}), NodeId{2});
}

TEST(ShareSpec, WhatNoCoordinatorSendsIsRefused) {
  EXPECT_FALSE(spec_from_bytes("\xff\xff"));
  EXPECT_FALSE(spec_from_bytes(""));  // no threads
  ShareSpec spec;
  spec.table.nodes = {{0}, {1}};  // without incarnations
  EXPECT_FALSE(spec_from_bytes(to_bytes(spec)));
}

TEST(ShareSpec, OfARunHasItsOptions) {
  RunOptions run;
  run.threads = 3;
  run.memory_bytes = 1ull << 40;
  run.kernel = KernelKind::cgal;
  run.keep = TileRetention::reduced;
  run.store = StoreAs::points;
  run.neighbors = run.resumable = false;
  run.grace_s = 300;
  run.lock_file = "out/.lock/me";
  const ShareSpec spec = spec_of(run, "out/.run", "out");
  EXPECT_EQ(spec.threads, 3u);
  EXPECT_EQ(spec.memory_bytes, 1ull << 40);
  EXPECT_FALSE(spec.resumable);
  EXPECT_EQ(spec.grace_s, 300u);
  EXPECT_EQ(spec.lock_file, "out/.lock/me");
  EXPECT_EQ(spec.run_folder, "out/.run");
  EXPECT_EQ(spec.out_folder, "out");
  const auto programs = delaunay_options_from_bytes(spec.programs);
  ASSERT_TRUE(programs);
  EXPECT_EQ(programs.value(), (DelaunayOptions{KernelKind::cgal, TileRetention::reduced, StoreAs::points, false}));
  EXPECT_FALSE(delaunay_options_from_bytes("\xff\xff"));
  EXPECT_FALSE(delaunay_options_from_bytes("\x08\x07"));  // a kernel that there is not
  EXPECT_FALSE(delaunay_options_from_bytes("\x20\x07"));  // a kind of tiles that there is not
}

}  // namespace
}  // namespace tessera
