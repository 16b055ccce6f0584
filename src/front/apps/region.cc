// tessera region: writes the cells of a region of raw clouds.
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/temporary.h"
#include "src/front/apps/command.h"
#include "src/front/apps/drawn.h"
#include "src/front/apps/interrupt.h"
#include "src/front/apps/log.h"
#include "src/front/apps/remote_drawing.h"
#include "src/front/apps/server_options.h"
#include "src/front/apps/triangulate_options.h"
#include "src/front/apps/words.h"
#include "src/job/arguments.h"
#include "src/job/region_job.h"
#include "src/result/export/export.h"
#include "src/result/query/area.h"
#include "src/tiling/budget/budget.h"

namespace tessera::apps {
namespace {

namespace fs = std::filesystem;

struct RegionCommand {
  std::vector<std::string> inputs;
  fs::path out;
  std::string format;     // of a file; empty: the format of the ending of `out`
  bool is_folder = true;  // `out` becomes a result folder
  bool overwrite = false;
  RegionJobOptions job;
  OutputOptions output;
};

Result<RegionJobOptions> read_job(Settings& settings) {
  JobOptions cloud;
  BOOST_OUTCOME_TRYV(read_cloud_options(settings, cloud));
  RegionJobOptions job;
  job.cloud = cloud.cloud;
  job.cloud.threads = budget::reading_threads(cloud.memory_bytes, cloud.threads);
  job.neighbors = cloud.neighbors;
  job.limits.memory_bytes = cloud.memory_bytes;
  BOOST_OUTCOME_TRY(box, settings.get("bbox", [&](const std::string& text) {
    return parse_crop(text, job.cloud.dimension == 2 ? 2 : 3);
  }));
  const auto polygon = settings.text("polygon");
  if (box && polygon) return error(Errc::usage, "give either --bbox or --polygon");
  if (polygon) {
    BOOST_OUTCOME_TRY(read, query::Polygon::read_geojson(*polygon));
    const Bounds& around = read.bounds();
    constexpr double inf = std::numeric_limits<double>::infinity();
    job.box = Box{{around.lo.x, around.lo.y, -inf}, {around.hi.x, around.hi.y, inf}};
    job.check_place = [place = read.place()](const std::string& crs, const Bounds& points) {
      return place.check_in(crs, points);
    };
    job.shape = [area = std::move(read)](std::span<const Point> cell) { return area.meets(cell); };
  } else if (box) {
    job.box = *box;
  } else {
    return error(Errc::usage, "no region is given; add --bbox xmin,ymin,xmax,ymax, or --polygon FILE");
  }
  BOOST_OUTCOME_TRY(scan, settings.on("scan-files"));
  job.scan_files = scan;
  BOOST_OUTCOME_TRY(points, settings.get("max-points", [](const std::string& text) { return parse_count(text); }));
  job.limits.max_points = points.value_or(job.limits.max_points);
  BOOST_OUTCOME_TRY(seconds, settings.get("max-seconds", [](const std::string& text) { return parse_distance(text); }));
  job.limits.max_seconds = seconds.value_or(job.limits.max_seconds);
  BOOST_OUTCOME_TRY(partial, settings.on("partial"));
  job.limits.partial = partial;
  return job;
}

Result<RegionCommand> read_command(Settings& settings, std::vector<std::string> inputs) {
  RegionCommand command;
  command.inputs = std::move(inputs);
  if (command.inputs.empty() && !settings.text("input-list"))
    return error(Errc::usage, "no input file is given; try 'tessera region --help'");
  BOOST_OUTCOME_TRY(job, read_job(settings));
  command.job = std::move(job);
  BOOST_OUTCOME_TRY(output, output_options(settings));
  command.output = output;
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  command.overwrite = overwrite;
  command.out = settings.text("output").value_or("");
  if (command.out.empty()) return error(Errc::usage, "no result folder is given; add -o FOLDER");
  command.format = settings.text("format").value_or("");
  command.is_folder = command.format.empty() && command.out.extension().empty();
  return command;
}

Result<RegionSummary> run_in(const RegionCommand& command, RegionCloud& cloud, const fs::path& out, bool overwrite,
                             const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(folder, ResultFolder::inspect(out, false, overwrite));
  auto summary = write_region(cloud, command.job, folder, stop);
  if (!summary) folder.abandon();
  return summary;
}

Status run_region(const RegionCommand& command) {
  const Interrupt interrupt;
  const ExportOptions exporting{.format = command.format, .overwrite = command.overwrite};
  if (command.is_folder) {  // checked before the input is read
    BOOST_OUTCOME_TRYV(ResultFolder::inspect(command.out, false, command.overwrite));
  } else {
    BOOST_OUTCOME_TRYV(find_export_target(command.out, exporting));
  }
  BOOST_OUTCOME_TRY(cloud, open_regions(command.inputs, command.job, interrupt.token()));
  if (command.is_folder) {
    BOOST_OUTCOME_TRY(summary, run_in(command, cloud, command.out, command.overwrite, interrupt.token()));
    print_drawn(summary, command.output);
    return success();
  }
  BOOST_OUTCOME_TRY(scratch, TemporaryFolder::make());
  BOOST_OUTCOME_TRY(summary, run_in(command, cloud, scratch.path(), true, interrupt.token()));
  BOOST_OUTCOME_TRY(exported, export_result(scratch.path(), command.out, exporting, interrupt.token()));
  summary.out = exported.path.string();
  print_drawn(summary, command.output);
  return success();
}

}  // namespace

Command add_region(CLI::App& root) {
  auto command = new_command(
      root, "region", "Triangulates a region of point files, reading only what its cells need",
      "  tessera region block/*.copc.laz --bbox 885100,629000,885150,629050 --dim 2 --class 2 -o part/\n"
      "  tessera region scan.copc.laz --bbox 515370,4918345,2323,515375,4918350,2330 -o part.vtu\n"
      "  tessera region block/*.copc.laz --polygon area.geojson --dim 2 --class 2 -o part/\n"
      "  tessera region block/*.laz --bbox 0,0,9,9 -o part/ --max-points 20M --max-seconds 60 --partial\n\n"
      "The cells are those of the whole triangulation that have a point in common with the region, its border "
      "included.\n"
      "Of COPC and EPT only the octree nodes that are needed are read; other files are read whole. Points that are\n"
      "not read are taken to lie in the box that their file states, unless --scan-files is given.");
  add_value(command, "bbox", "BOX", "xmin,ymin,xmax,ymax or xmin,ymin,zmin,xmax,ymax,zmax: the region", 0, true);
  add_value(command, "polygon", "FILE", "the region: the polygons of a GeoJSON file, in the coordinates of the points",
            0, true);
  add_value(command, "output", "PATH",
            "the result folder to write; with an ending or --format, a file or folder for other programs, as 'tessera "
            "export' writes",
            'o', true);
  add_value(command, "format", "NAME", "a format of 'tessera export': vtu, ply, npy, ...");
  add_choices(command, "format", export_format_names());
  add_value(command, "max-points", "N",
            "triangulate at most this many points, for example 20M; default: as many as the memory allows");
  add_value(command, "max-seconds", "S", "give up after about this many seconds; default: never");
  add_switch(command, "partial",
             "when one of these limits is reached, write the cells that are known, with the cell attribute final (0 or "
             "1), instead of failing");
  add_switch(command, "scan-files",
             "read all files once to see where their points are, instead of relying on the boxes that they state");
  add_point_options(command);
  add_switch(command, "overwrite", "replace a result or file that exists", 0, true);
  add_remote_options(command);
  add_output_switches(command);
  auto inputs = std::make_shared<std::vector<std::string>>();
  add_argument(command, "inputs", "FILE", *inputs, "point files, folders of them, patterns of their names");
  command.run = [settings = command.settings.get(), inputs](const std::vector<std::string>& command_line) -> Status {
    BOOST_OUTCOME_TRY(read, read_command(*settings, *inputs));
    if (read.output.verbose) log_everything();
    if (names_server(*settings))
      return region_remotely(*settings, {.inputs = read.inputs, .name = read.out.string(), .crs = read.job.cloud.crs},
                             read.output);
    BOOST_OUTCOME_TRYV(refuse_detach(*settings));
    read.job.command = command_line;
    return run_region(read);
  };
  return command;
}

}  // namespace tessera::apps
