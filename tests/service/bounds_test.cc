// Every kind of job draws from its ledger. A kind that is new fails here until there are inputs for it below, and then
// until it ends at its bound of disk, and when it is stopped.
#include <malloc.h>
#include <zlib.h>

#include <map>
#include <set>

#include "job_record.pb.h"
#include "src/base/files/names.h"
#include "src/base/ledger.h"
#include "src/job/engine_steps.h"
#include "src/result/tileset/tileset.h"
#include "src/service/processes/job_work.h"
#include "src/service/processes/kinds.h"
#include "src/service/processes/table.h"
#include "src/service/processes/workshop.h"
#include "src/service/staging_folder.h"
#include "tests/service/service_testing.h"

namespace tessera::service::testing {
namespace {

class Bounds : public ServiceTest {
 protected:
  // A job of each kind, and of each format of exports that is written in another way. All write more than a byte.
  std::vector<proto::Inputs> each_kind() const {
    std::vector<proto::Inputs> all;
    const auto add = [&]() -> proto::Inputs& { return all.emplace_back(); };
    add() = triangulate("plane.xyz", "new");
    // Its records are sorted in runs on disk when there is this little memory.
    auto& proved = *add().mutable_verify();
    proved.set_triangulation("large");
    proved.set_memory("1M");
    for (const char* output : {"mesh.ply", "mesh.vtu", "mesh.gpkg", "mesh.geojson", "mesh.csv", "arrays", "mesh.msh"}) {
      auto& exported = *add().mutable_export_();
      exported.set_triangulation("plane");
      exported.set_output(output);
      if (std::string(output) == "arrays") exported.set_format("npy");
    }
    auto& tiles = *add().mutable_export_();
    tiles.set_triangulation("plane");
    tiles.set_output("tiles");
    tiles.set_format(tileset_format);
    add().mutable_info()->add_inputs("packed.xyz.gz");
    auto& region = *add().mutable_region();
    region.add_inputs("plane.xyz");
    region.set_output("part");
    region.set_dim(2);
    for (const double side : {0.2, 0.2, 0.8, 0.8}) region.add_bbox(side);
    for (const bool shaded : {false, true}) {
      auto& raster = *add().mutable_dem();
      raster.set_triangulation("plane");
      raster.set_output("dem.tif");
      raster.set_res(0.02);
      raster.set_hillshade(shaded);
    }
    for (const char* output : {"lines.gpkg", "lines.geojson"}) {
      auto& lines = *add().mutable_contours();
      lines.set_triangulation("plane");
      lines.set_output(output);
      lines.set_interval(0.05);
    }
    for (const char* memory : {"1M", "1G"}) {  // tiles on disk, and in memory
      auto& surface = *add().mutable_surface();
      surface.set_triangulation("large");
      surface.set_output("mesh.ply");
      surface.set_memory(memory);
    }
    auto& levels = *add().mutable_surface();
    levels.set_triangulation("large");
    levels.set_format(tileset_format);
    for (const char* format : {"las", "laz"}) {
      auto& heights = *add().mutable_hag();
      heights.add_inputs("points.las");
      heights.set_triangulation("plane");
      heights.set_format(format);
    }
    auto& columns = *add().mutable_measure();
    columns.set_triangulation("measured");
    columns.set_volume(true);
    columns.set_quality(true);
    for (const char* output : {"", "next"}) {  // a new version, and a new result
      auto& change = *add().mutable_update();
      change.set_triangulation("measured");
      for (const std::uint64_t id : {1, 2, 3, 40'000}) change.add_remove_ids(id);
      change.set_output(output);
    }
    add_products(all);
    return all;
  }

  static void add_products(std::vector<proto::Inputs>& all) {
    const std::string square =
        R"({"type": "Polygon", "coordinates": [[[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8], [0.2, 0.2]]]})";
    for (const char* output : {"cells.gpkg", "cells.fgb", "cells.geojson", "cells.csv", "cells.vtu"}) {
      const bool spatial = std::string(output) == "cells.vtu";
      auto& cells = *all.emplace_back().mutable_voronoi();
      cells.set_triangulation(spatial ? "solid" : "plane");
      cells.set_output(output);
      if (spatial) cells.set_clip("0,0,0,1,1,1");
      if (std::string(output) == "cells.geojson") cells.set_clip(square);
    }
    for (const char* output : {"grid.tif", "grid.npy"}) {
      auto& grid = *all.emplace_back().mutable_density();
      grid.set_triangulation("plane");
      grid.set_output(output);
      grid.set_res(0.02);
    }
    for (const char* output : {"shape.ply", "shape.gpkg", "shape.geojson", "shape.fgb"}) {
      auto& shape = *all.emplace_back().mutable_alpha();
      shape.set_triangulation("plane");
      shape.set_output(output);
    }
    for (const char* output : {"volumes.csv", "volumes.json", "volumes.gpkg"}) {
      auto& volumes = *all.emplace_back().mutable_volume();
      volumes.set_triangulation("plane");
      volumes.set_output(output);
      volumes.set_plane(0.5);
      if (std::string(output) == "volumes.gpkg") volumes.set_within(square);
    }
  }

  void make_inputs() {
    make_cloud("volume.ply", 80'000);
    make_cloud("points.las", 20'000);
    std::ofstream plane(inputs() / "plane.xyz");
    std::string text;
    for (int i = 0; i < 2000; ++i)
      text += std::to_string(i * 7919 % 2003 / 2003.0) + " " + std::to_string(i * 104'729 % 1999 / 1999.0) + " " +
              std::to_string(i % 10 * 0.1) + "\n";
    plane << text;
    plane.close();
    ::gzFile packed = ::gzopen((inputs() / "packed.xyz.gz").c_str(), "wb");
    ASSERT_NE(packed, nullptr);
    ASSERT_GT(::gzwrite(packed, text.data(), static_cast<unsigned>(text.size())), 0);
    ::gzclose(packed);
    open();
    auto flat = triangulate("plane.xyz", "plane");
    flat.mutable_triangulate()->set_dim(2);
    ASSERT_EQ(ended(submit(flat)).status(), "successful");
    ASSERT_EQ(ended(submit(triangulate("plane.xyz", "solid"))).status(), "successful");
    auto large = triangulate("volume.ply", "large");
    large.mutable_triangulate()->set_tiles(8);
    ASSERT_EQ(ended(submit(large)).status(), "successful");
    service.reset();
  }

  std::set<std::string> files_of_data() const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(data())) names.insert(entry.path().string());
    return names;
  }

  // What do_work() says of the job, and what it leaves in the data folder.
  struct Done {
    Reply<JobDone> reply;
    std::set<std::string> left;
    std::uint64_t written = 0;
  };
  Done work_on(const proto::Inputs& inputs, Ledger& ledger) {
    Engine engine(2, options.memory_bytes, kinds_of_stages());
    auto roots = Roots::open(options.roots, "");
    EXPECT_TRUE(roots);
    std::filesystem::create_directories(results_folder(data()));
    const auto desk = StagingFolder::lay(results_folder(data()), 1000, [] { return Status(success()); });
    EXPECT_TRUE(desk) << desk.error().where;
    ResultFolders results(data(), *desk.value());
    EXPECT_TRUE(results.open({}));
    RegionClouds clouds(0);
    // A result that the job changes is a copy.
    const auto changed = results_folder(data()) / "measured";
    if (inputs.has_measure() || inputs.has_update())
      std::filesystem::copy(results_folder(data()) / "large", changed, std::filesystem::copy_options::recursive);
    const auto before = files_of_data();
    const Workshop shop{engine, roots.value(), results, data(), {}, {2, options.memory_bytes}, clouds};
    proto::JobRecord record;
    record.set_id("20260101T000000Z-000000");
    *record.mutable_inputs() = inputs;
    record.set_triangulation(makes_result(inputs) ? result_output(inputs) : result_read(inputs));
    record.set_starts(1);
    Progress progress;
    auto reply = do_work(shop, {record, progress, ledger, [](const std::string&) {}, folder.path()});
    std::set<std::string> left;
    for (const auto& name : files_of_data())
      if (!before.contains(name)) left.insert(name);
    for (const auto& name : left) std::filesystem::remove_all(name);
    std::filesystem::remove_all(changed);
    return {std::move(reply), left, ledger.written()};
  }
};

TEST_F(Bounds, EveryKindOfJobIsTriedHere) {
  std::set<std::string> tried, there;
  for (const auto& inputs : each_kind()) tried.insert(process_of(inputs));
  const auto& kinds = *proto::Inputs::descriptor()->FindOneofByName("of");
  for (int i = 0; i < kinds.field_count(); ++i) there.insert(kinds.field(i)->name());
  EXPECT_EQ(tried, there);
}

TEST_F(Bounds, EveryKindOfJobEndsAtItsBoundOfDiskNamesItAndLeavesNothing) {
  make_inputs();
  for (const auto& inputs : each_kind()) {
    SCOPED_TRACE(inputs.ShortDebugString());
    Ledger ample;
    const auto whole = work_on(inputs, ample);
    ASSERT_TRUE(whole.reply) << whole.reply.error().detail();
    ASSERT_GT(whole.written, 1U) << "it draws nothing";
    // At its first byte, in the middle, and near its end.
    for (const std::uint64_t most : {std::uint64_t{1}, whole.written / 2, whole.written / 10 * 9}) {
      Ledger ledger({.disk = {most, "limits.disk, so little,"}});
      const auto done = work_on(inputs, ledger);
      ASSERT_FALSE(done.reply) << most << " of " << whole.written;
      EXPECT_EQ(done.reply.error().detail(), "the job needs more disk than limits.disk, so little, allows");
      EXPECT_EQ(done.reply.error().status(), 422);
      // A change whose last files do not fit leaves what the next change removes (src/result/new_version.h).
      if (inputs.has_update() && inputs.update().output().empty()) continue;
      EXPECT_EQ(done.left, std::set<std::string>()) << most << " of " << whole.written;
    }
  }
}

TEST_F(Bounds, EveryKindOfJobLeavesTheReserveOfTheDiskFree) {
  make_inputs();
  for (const auto& inputs : each_kind()) {
    SCOPED_TRACE(inputs.ShortDebugString());
    Ledger ledger({.reserve_bytes = 1 << 20, .free_bytes = [] { return std::uint64_t{1} << 19; }});
    const auto done = work_on(inputs, ledger);
    ASSERT_FALSE(done.reply);
    EXPECT_EQ(done.reply.error().status(), 507) << done.reply.error().detail();
    EXPECT_NE(done.reply.error().detail().find("limits.reserve"), std::string::npos);
  }
}

TEST_F(Bounds, AJobOfWhateverKindThatIsStoppedWhileItWritesWritesNoMoreAndLeavesNothing) {
  make_inputs();
  for (const auto& inputs : each_kind()) {
    if (inputs.has_triangulate() || inputs.has_surface() || inputs.has_update())
      continue;  // they keep what they can go on with
    SCOPED_TRACE(inputs.ShortDebugString());
    Ledger* stopped = nullptr;
    std::uint64_t drawn = 0;
    // The ledger looks at the disk when the first bytes are to be written.
    Ledger ledger({.free_bytes = [&] {
      stopped->stop();
      drawn = stopped->written();
      return std::uint64_t{1} << 40;
    }});
    stopped = &ledger;
    const auto done = work_on(inputs, ledger);
    ASSERT_FALSE(done.reply);
    EXPECT_EQ(done.reply.error().cause(), static_cast<int>(Errc::interrupted)) << done.reply.error().detail();
    EXPECT_EQ(done.left, std::set<std::string>());
    EXPECT_GT(drawn, 0U);
    EXPECT_EQ(done.written, drawn);
  }
}

TEST_F(Bounds, AStoppedJobOfWhateverKindEnds) {
  make_inputs();
  for (const auto& inputs : each_kind()) {
    SCOPED_TRACE(inputs.ShortDebugString());
    Ledger ledger;
    ledger.stop();
    const auto done = work_on(inputs, ledger);
    ASSERT_FALSE(done.reply);
    EXPECT_EQ(done.reply.error().cause(), static_cast<int>(Errc::interrupted)) << done.reply.error().detail();
  }
}

TEST_F(Bounds, ARasterOfFewLargeCellsIsDrawnInParts) {
  std::ofstream(inputs() / "square.xyz") << "0 0 1\n1 0 2\n0 1 3\n1 1 4\n";
  open();
  auto flat = triangulate("square.xyz", "square");
  flat.mutable_triangulate()->set_dim(2);
  ASSERT_EQ(ended(submit(flat)).status(), "successful");
  service.reset();
  proto::Inputs raster;
  raster.mutable_dem()->set_triangulation("square");
  raster.mutable_dem()->set_res(1.0 / 6000);  // all pixels together take 288 MB
  raster.mutable_dem()->set_memory("64M");
  const auto allocated = [] {
    const auto info = ::mallinfo2();
    return info.uordblks + info.hblkhd;
  };
  const auto before = allocated();
  std::uint64_t most = 0;
  Ledger* stopped = nullptr;
  // Asked when the first pixels are handed over.
  Ledger ledger({.free_bytes = [&] {
    most = allocated() - before;
    stopped->stop();
    return std::uint64_t{1} << 40;
  }});
  stopped = &ledger;
  ASSERT_FALSE(work_on(raster, ledger).reply);
  EXPECT_GT(most, 0U);
  EXPECT_LT(most, std::uint64_t{200} << 20);
}

}  // namespace
}  // namespace tessera::service::testing
