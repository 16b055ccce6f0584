#include "src/front/apps/triangulate_options.h"

#include <algorithm>
#include <utility>

#include "src/front/apps/machine_options.h"
#include "src/job/arguments.h"
#include "src/job/machine.h"
#include "src/job/parse_crs.h"

namespace tessera::apps {
namespace {

Result<std::uint64_t> parse_positive_count(const std::string& text) {
  BOOST_OUTCOME_TRY(count, parse_count(text));
  if (count == 0) return error(Errc::usage, "must be at least 1");
  return count;
}

Result<KernelKind> parse_kernel(const std::string& text) {
  if (text == "flat") return KernelKind::flat;
  if (text == "cgal") return KernelKind::cgal;
  return error(Errc::usage, "'" + text + "' is not a kernel; the kernels are flat and cgal");
}

}  // namespace

void add_store_options(Command& command) {
  add_value(
      command, "endpoint", "URL",
      "s3://: a server other than Amazon's, as https://host:port; default: AWS_ENDPOINT_URL, or what ~/.aws says");
  add_value(command, "profile", "NAME", "s3://: the profile in ~/.aws that says who asks; default: AWS_PROFILE");
  add_switch(command, "anonymous", "s3://: do not sign requests, for objects that anyone may read");
  add_switch(command, "requester-pays", "s3://: agree to pay for what is transferred, where the owner wants that");
}

void add_source_options(Command& command) {
  add_switch(command, "recursive", "take the files in subfolders of input folders, too");
  add_store_options(command);
  add_value(command, "class", "LIST", "keep only points of these LAS classes, for example 2,9");
  add_value(command, "scan", "LIST", "E57, PTX: keep only points of these scans, numbered from 0, for example 0,2");
  add_value(command, "particles", "TYPES",
            "snapshots: read only particles of these types: gas, dark-matter, disk, bulge, stars, black-holes, "
            "neutrinos, or numbers; default: all");
  add_value(command, "returns", "WHICH", "LAS: keep the first, last or single return of each pulse; default: all");
  add_value(command, "without", "FLAGS",
            "LAS: drop points with one of these flags: withheld, synthetic, overlap, key_point");
  add_value(command, "columns", "NAMES",
            "text, NumPy: the names of the columns, in order: x, y, z, the name of an attribute, or _ for a column to "
            "leave out; for example p,y,x,z; FITS: which columns are coordinates, as x=XPOS,y=YPOS,z=ZPOS, "
            "position=POS, or ra=RA,dec=DEC and redshift=Z or distance=D");
  add_value(command, "hdu", "WHICH", "FITS: the number or the name of the table; default: the first table");
  add_value(command, "cosmology", "H0,OM",
            "FITS: turn redshifts into comoving distances, in a flat universe with this H0 in km/s/Mpc and this "
            "density of matter; for example 70,0.3");
  add_value(command, "crs", "CRS",
            "the coordinate system of all input files, whatever they say: EPSG:n, WKT, or a file with one of them");
  add_value(command, "attributes", "NAMES",
            "carry these attributes of the points to the result, for example intensity,red; or all");
  add_value(command, "keep", "WHICH",
            "2D: of points with equal x and y keep the first (default), last, lowest or highest; for lowest and "
            "highest, heights that are not numbers come last");
  add_choices(command, "keep", "first, last, lowest, highest");
  add_switch(command, "skip-invalid", "drop points with NaN or infinite coordinates, instead of refusing the file");
}

void add_dimension(Command& command) {
  add_value(command, "dim", "2|3",
            "triangulate in 2D (x and y alone) or 3D; default: 3, or 2 when the files hold x and y alone");
}

void add_point_options(Command& command) {
  add_value(command, "input-list", "FILE",
            "read more inputs from this text file (- for standard input), one a line; relative names begin at the "
            "folder of the file",
            0, true);
  add_source_options(command);
  add_value(
      command, "resolution", "R",
      "COPC and EPT: read only the octree levels down to the first whose points are at most R apart; default: all");
  add_dimension(command);
  add_threads_option(command);
  add_value(command, "memory", "SIZE",
            "memory the job may use, for example 800M or 4G; default: 70 % of what is available");
  add_switch(command, "z", "2D: do not carry the heights z of the input as the attribute z", 0, false, true);
  add_switch(command, "neighbors", "leave out the neighbours of cells; the files are half as large", 0, false, true);
}

void add_cloud_options(Command& command) {
  add_point_options(command);
  add_value(command, "max-points-per-tile", "N",
            "how many points a tile may hold at most, for example 500k; default: chosen from memory and threads");
  add_value(command, "tiles", "N", "the number of tiles, instead of their size");
  add_value(command, "partition", "KIND", "kdtree (default), grid, octree, or random (for tests: no spatial order)");
  add_choices(command, "partition", "kdtree, grid, octree, random");
  add_value(command, "crop", "BOX", "xmin,ymin,xmax,ymax or xmin,ymin,zmin,xmax,ymax,zmax: drop points outside");
}

Status read_cloud_options(Settings& settings, JobOptions& options) {
  const auto given = [&](const char* key) { return settings.text(key).value_or("auto") != "auto"; };
  if (given("tiles") && given("max-points-per-tile")) {
    BOOST_OUTCOME_TRYV(settings.exclusive("tiles", "max-points-per-tile"));
  }
  BOOST_OUTCOME_TRY(dimension,
                    settings.get("dim", or_auto([](const std::string& text) { return parse_integer(text, 2, 3); }, 0)));
  options.cloud.dimension = static_cast<int>(dimension.value_or(0));
  BOOST_OUTCOME_TRY(limit, settings.get("max-points-per-tile", or_auto(parse_positive_count, 0)));
  options.max_points_per_tile = limit.value_or(0);
  BOOST_OUTCOME_TRY(tiles, settings.get("tiles", or_auto(parse_positive_count, 0)));
  if (tiles.value_or(0) > Partition::tiles_max) {
    return error(Errc::usage, "--tiles: more than " + std::to_string(Partition::tiles_max) + " tiles are not possible");
  }
  options.tiles = static_cast<std::uint32_t>(tiles.value_or(0));
  BOOST_OUTCOME_TRY(partition,
                    settings.get("partition", [](const std::string& text) { return parse_partition_kind(text); }));
  options.partition = partition.value_or(PartitionKind::kdtree);
  BOOST_OUTCOME_TRY(threads, threads_option(settings));
  options.threads = threads;
  BOOST_OUTCOME_TRY(memory,
                    settings.get("memory", or_auto([](const std::string& text) { return parse_memory(text); }, 0)));
  options.memory_bytes = given("memory") ? *memory : default_memory();
  BOOST_OUTCOME_TRY(crop, settings.get("crop", [&](const std::string& text) {
    return parse_crop(text, options.cloud.dimension == 2 ? 2 : 3);
  }));
  options.cloud.crop = crop;
  BOOST_OUTCOME_TRY(
      resolution, settings.get("resolution", or_auto([](const std::string& text) { return parse_distance(text); }, 0)));
  options.cloud.resolution = resolution.value_or(0);
  options.cloud.threads = options.threads;
  options.cloud.input_list = settings.text("input-list").value_or("");
  BOOST_OUTCOME_TRY(recursive, settings.on("recursive"));
  options.cloud.recursive = recursive;
  BOOST_OUTCOME_TRY(classes, settings.get("class", [](const std::string& text) { return parse_classes(text); }));
  options.cloud.classes = classes.value_or(std::vector<int>{});
  BOOST_OUTCOME_TRY(scans, settings.get("scan", [](const std::string& text) { return parse_scans(text); }));
  options.cloud.scans = scans.value_or(std::vector<std::uint32_t>{});
  BOOST_OUTCOME_TRY(particles,
                    settings.get("particles", [](const std::string& text) { return parse_particles(text); }));
  options.cloud.particles = particles.value_or(std::vector<std::uint32_t>{});
  BOOST_OUTCOME_TRY(returns, settings.get("returns", [](const std::string& text) { return parse_returns(text); }));
  options.cloud.returns = returns.value_or(Returns::all);
  BOOST_OUTCOME_TRY(without, settings.get("without", [](const std::string& text) -> Result<std::vector<std::string>> {
    BOOST_OUTCOME_TRY(flags, parse_names(text));
    BOOST_OUTCOME_TRYV(check_flags(flags));
    return std::move(flags);
  }));
  options.cloud.without = without.value_or(std::vector<std::string>{});
  BOOST_OUTCOME_TRY(columns, settings.get("columns", parse_columns));
  options.cloud.columns = columns.value_or(std::vector<std::string>{});
  options.cloud.hdu = settings.text("hdu").value_or("");
  BOOST_OUTCOME_TRY(cosmology,
                    settings.get("cosmology", [](const std::string& text) { return parse_cosmology(text); }));
  options.cloud.cosmology = cosmology;
  BOOST_OUTCOME_TRY(crs, settings.get("crs", parse_crs));
  options.cloud.crs = crs.value_or("");
  BOOST_OUTCOME_TRY(attributes, settings.get("attributes", [](const std::string& text) { return parse_names(text); }));
  options.cloud.attributes = attributes.value_or(std::vector<std::string>{});
  BOOST_OUTCOME_TRY(heights, settings.get("z", [](const std::string& text) { return parse_switch(text); }));
  options.cloud.heights = heights.value_or(true);
  BOOST_OUTCOME_TRY(keep, settings.get("keep", [](const std::string& text) { return parse_kept_point(text); }));
  options.cloud.keep = keep.value_or(DuplicatePolicy::first);
  BOOST_OUTCOME_TRY(skip_invalid, settings.on("skip-invalid"));
  options.cloud.skip_invalid = skip_invalid;
  BOOST_OUTCOME_TRY(neighbors, settings.get("neighbors", [](const std::string& text) { return parse_switch(text); }));
  options.neighbors = neighbors.value_or(true);
  return success();
}

void add_triangulate_options(Command& command) {
  add_value(command, "output", "FOLDER", "the result folder; with --server, the name of the result", 'o', true);
  add_cloud_options(command);
  add_value(command, "store", "WHAT",
            "cells: files that ParaView opens; points: a tenth of the bytes, cells are made again when they are asked "
            "for; auto (default): points for clouds of more than 50 million points, else cells");
  add_choices(command, "store", "auto, cells, points");
  add_value(command, "periodic", "L",
            "the cloud is periodic: its box begins at 0, has the side L, and opposite sides are the same place; or "
            "Lx,Ly,Lz (2D: Lx,Ly), 0 for an axis without a period; or file: as the snapshot says");
  add_value(command, "periodic-snap", "yes|no",
            "round coordinates and periods that have too many binary digits for exact images (default), by 2^-52 of "
            "the period at most, or refuse them");
  add_choices(command, "periodic-snap", "yes, no");
  add_value(command, "kernel", "KIND", "the Delaunay kernel: flat (default) or cgal");
  add_choices(command, "kernel", "flat, cgal");
  add_switch(command, "resume", "continue the unfinished run in the result folder, or start one", 0, true);
  add_switch(command, "overwrite", "replace the result or unfinished run in the result folder", 0, true);
  add_output_switches(command);
}

Result<TriangulateOptions> read_triangulate_options(Settings& settings, std::vector<std::string> inputs) {
  TriangulateOptions options;
  BOOST_OUTCOME_TRYV(read_cloud_options(settings, options.job));
  BOOST_OUTCOME_TRY(store, settings.get("store", [](const std::string& text) { return parse_store_as(text); }));
  options.job.store = store.value_or(StoreAs::by_size);
  BOOST_OUTCOME_TRY(kernel, settings.get("kernel", parse_kernel));
  options.job.kernel = kernel.value_or(KernelKind::flat);
  options.job.cloud.periodic_files = settings.text("periodic") == "file";
  if (!options.job.cloud.periodic_files) {
    BOOST_OUTCOME_TRY(periodic, settings.get("periodic", [](const std::string& text) { return parse_periods(text); }));
    options.job.cloud.periodic = periodic.value_or(std::vector<double>{});
  }
  BOOST_OUTCOME_TRY(snap, settings.get("periodic-snap", [](const std::string& text) { return parse_switch(text); }));
  options.job.cloud.snap = snap.value_or(true);
  BOOST_OUTCOME_TRY(output, output_options(settings));
  options.output = output;
  if (inputs.empty() && options.job.cloud.input_list.empty())
    return error(Errc::usage, "no input file is given; try 'tessera triangulate --help'");
  for (const auto& input : inputs) {
    if (input.empty()) return error(Errc::usage, "an input file has an empty name");
  }
  options.inputs = std::move(inputs);
  options.out = settings.text("output").value_or("");
  if (options.out.empty()) return error(Errc::usage, "no result folder is given; add -o FOLDER");
  BOOST_OUTCOME_TRY(resume, settings.on("resume"));
  BOOST_OUTCOME_TRY(overwrite, settings.on("overwrite"));
  if (resume && overwrite)
    return error(Errc::usage, "--resume and --overwrite contradict each other: give one of them");
  options.resume = resume;
  options.overwrite = overwrite;
  if (resume && reads_standard_input(options))
    return error(Errc::usage, "--resume: standard input cannot be read again; save it in a file, and triangulate that");
  return options;
}

bool reads_standard_input(const TriangulateOptions& options) {
  return std::find(options.inputs.begin(), options.inputs.end(), "-") != options.inputs.end();
}

}  // namespace tessera::apps
