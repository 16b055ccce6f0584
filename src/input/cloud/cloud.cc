#include "src/input/cloud/cloud.h"

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "src/base/option.h"
#include "src/input/bytes/objects.h"
#include "src/input/bytes/spool.h"
#include "src/input/cloud/cloud_crs.h"
#include "src/input/cloud/in_order.h"
#include "src/input/cloud/inputs.h"
#include "src/input/cloud/point_filter.h"
#include "src/input/cloud/settle_period.h"
#include "src/input/column_names.h"
#include "src/input/snapshot/particle_types.h"
#include "src/input/snapshot/snapshot_set.h"

namespace tessera {
namespace {

// Adds the attributes of a file. An attribute keeps its type if all files agree, else it becomes a double. Its unit is
// unknown if files state different ones.
void add_available(const FileInfo& file, std::vector<Attribute>& available) {
  for (const auto& a : file.attributes) {
    const auto same = std::find_if(available.begin(), available.end(), [&](auto& b) { return b.name == a.name; });
    if (same == available.end()) {
      available.push_back(a);
      continue;
    }
    if (same->type != a.type) same->type = AttributeType::f64;
    if (same->unit != a.unit) same->unit.clear();
  }
}

Result<std::vector<Attribute>> choose(const std::vector<std::string>& wanted, const std::vector<Attribute>& available) {
  std::vector<Attribute> schema;
  for (const auto& name : wanted) {
    if (name == "all") return available;
    const auto found = std::find_if(available.begin(), available.end(), [&](auto& a) { return a.name == name; });
    if (found == available.end()) {
      std::string names;
      for (const auto& a : available) names += (names.empty() ? "" : ", ") + a.name;
      return error(Errc::usage, "no input file has an attribute '" + name + "'; there " +
                                    (names.empty() ? "are none" : "are " + names));
    }
    if (std::find(schema.begin(), schema.end(), *found) == schema.end()) schema.push_back(*found);
  }
  return schema;
}

// Adds what tells readers where points are.
ReadHints coordinates_of(const CloudOptions& options, ReadHints hints) {
  hints.columns = options.columns;
  hints.hdu = options.hdu;
  hints.cosmology = options.cosmology;
  return hints;
}

// Adds what lets readers skip points.
ReadHints filters_of(const CloudOptions& options, ReadHints hints) {
  hints.crop = options.crop;
  hints.scans = options.scans;
  hints.particles = options.particles;
  hints.resolution = options.resolution;
  return hints;
}

struct Opened {
  FileInfo info;
  std::shared_ptr<const ByteSource> spooled;  // null if the file itself can be read again
};

Result<Opened> open_input(const InputName& input, const ReadHints& hints, Spool& spool, const std::stop_token& stop) {
  Opened opened;
  std::shared_ptr<const ByteSource> source;
  if (input.standard_input) {
    BOOST_OUTCOME_TRY(all, spool.standard_input());
    opened.spooled = source = std::move(all);
  } else if (names_object(input.path)) {  // stays open, so that every read is of the same version of the object
    BOOST_OUTCOME_TRY(object, open_object(input.path, stop));
    BOOST_OUTCOME_TRY(content, spool.unpacked(std::move(object)));
    opened.spooled = source = std::move(content);
  } else {
    BOOST_OUTCOME_TRY(file, open_file(input.path));
    source = std::move(file);
    BOOST_OUTCOME_TRY(content, spool.unpacked(source));
    if (content != source) opened.spooled = source = std::move(content);
  }
  BOOST_OUTCOME_TRY(reader, open_reader(share(std::move(source)), {}, hints));
  opened.info = reader->info();
  return opened;
}

Status check_file(const FileInfo& file, const CloudOptions& options) {
  if (file.dimension < options.dimension)
    return error(Errc::bad_input, file.path.string() + ": has only x and y, but a 3D triangulation needs z, too (see " +
                                      option("dim") + ")");
  if (options.resolution > 0 && !file.levels)
    return error(Errc::usage, file.path.string() + ": is neither COPC nor EPT, so it has no levels for " +
                                  option("resolution") + " to choose from");
  for (const auto& [name, key] : filtered_by(options)) {
    if (std::none_of(file.attributes.begin(), file.attributes.end(),
                     [&, name = name](auto& a) { return a.name == name; }))
      return error(Errc::usage, file.path.string() + ": has no attribute '" + name + "', so " + option(key) +
                                    " cannot choose points by it");
  }
  return success();
}

// Degrees with heights have no meaningful Delaunay triangulation, because distances would mix angles and lengths.
Status check_units(const FileInfo& file) {
  if (!file.degrees) return success();
  return error(Errc::bad_input, file.path.string() +
                                    ": its header names longitude and latitude, which are degrees, beside a height, "
                                    "which is a length: convert them to a projected system, or triangulate the plane "
                                    "of degrees with " +
                                    option("dim", "2"));
}

Status check_use_of_columns(const std::vector<FileInfo>& files, const CloudOptions& options) {
  const auto has_columns = [](const FileInfo& file) { return file.columns.has_value(); };
  if (options.columns.empty() || are_entries(options.columns) || std::any_of(files.begin(), files.end(), has_columns))
    return success();
  return error(Errc::usage,
               option("columns") + ": none of the input files is text or NumPy, and other files have no columns");
}

std::string common_unit(const std::vector<FileInfo>& files) {
  const std::string& first = files.front().unit;
  const bool same = std::all_of(files.begin(), files.end(), [&](const FileInfo& file) { return file.unit == first; });
  return same ? first : "";
}

// An option for FITS that no file uses is a mistake.
Status check_use_of_fits(const std::vector<FileInfo>& files, const CloudOptions& options) {
  const auto any = [&](auto holds) { return std::any_of(files.begin(), files.end(), holds); };
  const bool tables = any([](const FileInfo& file) { return file.format == "fits"; });
  const auto refuse = [](const char* key) {
    return error(Errc::usage, option(key) + ": none of the input files is a FITS table");
  };
  if (are_entries(options.columns) && !tables) return refuse("columns");
  if (!options.hdu.empty() && !tables) return refuse("hdu");
  if (options.cosmology && !any([](const FileInfo& file) { return file.redshifts; }))
    return error(Errc::usage, option("cosmology") + ": none of the input files has places by a redshift");
  return success();
}

// Refuses types of particles that no snapshot has. What other files have is not known before they are read.
Status check_particles(const std::vector<FileInfo>& files, const CloudOptions& options) {
  std::map<std::uint32_t, std::uint64_t> there;
  for (const FileInfo& file : files) {
    if (file.particles.empty() && !file.snapshot) return success();
    for (const ParticleKind& kind : file.particles) there[kind.type] += kind.count;
  }
  for (const std::uint32_t type : options.particles) {
    if (there.contains(type)) continue;
    std::string types;
    for (const auto& [number, count] : there)
      types += (types.empty() ? "" : ", ") + std::to_string(count) + " of type " + std::to_string(number) + " (" +
               snapshot::name_of_type(number) + ")";
    return error(Errc::usage, option("particles") + ": the input has no particles of type " + std::to_string(type) +
                                  " (" + snapshot::name_of_type(type) + "), but " + types);
  }
  return success();
}

// Warns of numbers of points that were taken for coordinates, which is easily overlooked.
void warn_of_counting(const std::vector<FileInfo>& files, std::vector<std::string>& warnings) {
  const auto first = std::find_if(files.begin(), files.end(), [](const FileInfo& file) { return file.counts_up; });
  if (first == files.end()) return;
  const auto count = std::count_if(first, files.end(), [](const FileInfo& file) { return file.counts_up; });
  warnings.push_back((count == 1 ? first->path.string() + " has"
                                 : std::to_string(count) + " files, " + first->path.string() + " the first, have") +
                     " no header that names x and y, and a first column that counts up by one from line to line, which "
                     "is taken for x; if it numbers the points, name the columns by the option columns, as p,y,x,z");
}

// `carried`: the points have heights as an attribute. `has_z`: a file has heights.
Status check_keep(const CloudOptions& options, bool carried, bool has_z) {
  if (options.keep == DuplicatePolicy::first) return success();
  const auto refuse = [&](const std::string& reason) {
    return error(Errc::usage, option("keep", name_of(options.keep)) + ": " + reason);
  };
  if (options.dimension != 2)
    return refuse("chooses among points of equal x and y, which become one vertex only in 2D (see " + option("dim") +
                  ")");
  if (!is_by_height(options.keep) || carried) return success();
  return refuse(has_z ? "needs the heights, which " + option("z", "false") + " leaves out"
                      : "needs heights, and no input file has any");
}

// The schema: the attributes that are wanted and available, and in 2D the heights.
Result<std::vector<Attribute>> choose_with_heights(const CloudOptions& options, std::vector<Attribute> available,
                                                   bool has_z) {
  const Attribute height{"z", AttributeType::f64};
  const bool liftable = options.dimension == 2 && has_z;
  if (liftable) available.push_back(height);
  BOOST_OUTCOME_TRY(schema, choose(options.attributes, available));
  if (liftable && options.heights && std::find(schema.begin(), schema.end(), height) == schema.end())
    schema.push_back(height);
  BOOST_OUTCOME_TRYV(check_keep(options, std::find(schema.begin(), schema.end(), height) != schema.end(), has_z));
  return std::move(schema);
}

}  // namespace

Result<Cloud> Cloud::open(const std::vector<std::string>& patterns, CloudOptions options, std::stop_token stop) {
  if (options.dimension != 0 && options.dimension != 2 && options.dimension != 3)
    return error(Errc::usage, "the dimension must be 2 or 3");
  Cloud cloud;
  Spool spool(options.spool_folder, stop, options.spool_bytes_max);
  BOOST_OUTCOME_TRY(
      inputs, find_inputs({.patterns = patterns, .list = options.input_list, .recursive = options.recursive}, spool));
  const ReadHints hints = filters_of(options, coordinates_of(options, {}));
  const auto open_one = [&](std::size_t i) -> Result<Opened> {
    // No thread may wait for standard input while there is an error to report.
    if (inputs[i].standard_input) return Opened{};
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while the input files were opened");
    auto opened = open_input(inputs[i], hints, spool, stop);
    if (opened.has_error()) return inputs[i].explained(opened.error());
    return opened;
  };
  BOOST_OUTCOME_TRYV(in_order(inputs.size(), options.threads, open_one, [&](std::size_t i, Opened opened) -> Status {
    if (inputs[i].standard_input) {
      BOOST_OUTCOME_TRY(read, open_input(inputs[i], hints, spool, stop));
      opened = std::move(read);
    }
    cloud.files_.push_back(std::move(opened.info));
    cloud.spooled_.push_back(std::move(opened.spooled));
    return success();
  }));
  const bool has_z =
      std::any_of(cloud.files_.begin(), cloud.files_.end(), [](const auto& file) { return file.dimension == 3; });
  if (options.dimension == 0) options.dimension = has_z ? 3 : 2;
  std::vector<Attribute> available;
  for (std::size_t i = 0; i < cloud.files_.size(); ++i) {
    auto status = check_file(cloud.files_[i], options);
    if (status && options.dimension == 3) status = check_units(cloud.files_[i]);
    if (status.has_error()) return inputs[i].explained(status.error());
    add_available(cloud.files_[i], available);
  }
  BOOST_OUTCOME_TRYV(check_use_of_columns(cloud.files_, options));
  BOOST_OUTCOME_TRYV(check_use_of_fits(cloud.files_, options));
  BOOST_OUTCOME_TRYV(snapshot::check_snapshots(cloud.files_));
  BOOST_OUTCOME_TRYV(check_particles(cloud.files_, options));
  BOOST_OUTCOME_TRY(schema, choose_with_heights(options, std::move(available), has_z));
  cloud.schema_ = std::move(schema);
  BOOST_OUTCOME_TRY(settled, settle_crs(cloud.files_, options.crs));
  cloud.crs_ = std::move(settled.crs);
  cloud.unit_ = common_unit(cloud.files_);
  cloud.warnings_ = std::move(settled.warnings);
  warn_of_counting(cloud.files_, cloud.warnings_);
  BOOST_OUTCOME_TRYV(take_box_of_files(cloud.files_, options));
  BOOST_OUTCOME_TRYV(settle_period(options, cloud.warnings_));
  cloud.options_ = std::move(options);
  return cloud;
}

Result<Cloud> Cloud::open_source(std::shared_ptr<const ByteSource> source, CloudOptions options) {
  Cloud cloud;
  BOOST_OUTCOME_TRY(reader, open_reader(share(source), {}, coordinates_of(options, {})));
  BOOST_OUTCOME_TRYV(check_file(reader->info(), options));
  BOOST_OUTCOME_TRYV(settle_period(options, cloud.warnings_));
  BOOST_OUTCOME_TRY(schema, choose_with_heights(options, reader->info().attributes, reader->info().dimension == 3));
  cloud.files_.push_back(reader->info());
  cloud.spooled_.push_back(std::move(source));
  cloud.schema_ = std::move(schema);
  cloud.crs_ = options.crs.empty() ? reader->info().crs : options.crs;
  cloud.unit_ = reader->info().unit;
  cloud.options_ = std::move(options);
  return cloud;
}

Cloud Cloud::of(std::vector<FileInfo> files, std::vector<Attribute> schema, CloudOptions options) {
  Cloud cloud;
  cloud.spooled_.resize(files.size());
  cloud.files_ = std::move(files);
  cloud.schema_ = std::move(schema);
  cloud.options_ = std::move(options);
  return cloud;
}

InputSplit Cloud::whole() const {
  InputSplit split;
  for (std::size_t i = 0; i < files_.size(); ++i) split.ranges.push_back({i});
  return split;
}

Result<std::unique_ptr<ByteSource>> Cloud::source(std::size_t index) const {
  const FileInfo& file = files_[index];
  if (spooled_[index]) return share(spooled_[index]);
  BOOST_OUTCOME_TRY(source, open_file(file.path));
  // The file must not have changed: what was chosen by the first look at it, such as a partition or units, would be
  // wrong.
  if (source->stored_bytes() != file.bytes || source->modified_ns() != file.modified_ns)
    return error(Errc::bad_input, file.path.string() + ": was changed by another program while it was read");
  return std::move(source);
}

Result<std::unique_ptr<PointReader>> Cloud::reopen(std::size_t index, const std::vector<Attribute>& schema,
                                                   ReadHints hints) const {
  return reopen_whole(index, schema, filters_of(options_, std::move(hints)));
}

Result<std::unique_ptr<PointReader>> Cloud::reopen_whole(std::size_t index, const std::vector<Attribute>& schema,
                                                         ReadHints hints) const {
  BOOST_OUTCOME_TRY(bytes, source(index));
  return open_reader(std::move(bytes), schema, coordinates_of(options_, std::move(hints)));
}

}  // namespace tessera
