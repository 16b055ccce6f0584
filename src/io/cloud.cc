#include "src/io/cloud.h"

#include <glob.h>
#include <sys/stat.h>

#include <algorithm>
#include <map>
#include <utility>

#include "src/io/byte_source.h"
#include "src/io/point_filter.h"

namespace tessera {
namespace {

bool exists(const std::string& path) {
  struct stat status {};
  return ::lstat(path.c_str(), &status) == 0;
}

// The files a pattern stands for, sorted by bytes: the order gives the points their ids, so no locale may change it.
Result<std::vector<std::string>> expand(const std::string& pattern) {
  // A name may hold the characters of a pattern; what exists is meant literally.
  if (exists(pattern) || pattern.find_first_of("*?[") == std::string::npos) return std::vector{pattern};
  glob_t found{};
  const int code = ::glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found);
  std::vector<std::string> paths(found.gl_pathv, found.gl_pathv + (code == 0 ? found.gl_pathc : 0));
  ::globfree(&found);
  if (code == GLOB_NOMATCH || (code == 0 && paths.empty()))
    return error(Errc::io, pattern + ": no file matches this pattern");
  if (code != 0) return error(Errc::io, pattern + ": the folders of this pattern cannot be read");
  std::sort(paths.begin(), paths.end());
  return paths;
}

// The type that holds an attribute of all files: theirs if they agree, double if not.
void add_available(const FileInfo& file, std::vector<Attribute>& available) {
  for (const auto& a : file.attributes) {
    const auto same = std::find_if(available.begin(), available.end(), [&](auto& b) { return b.name == a.name; });
    if (same == available.end())
      available.push_back(a);
    else if (same->type != a.type)
      same->type = AttributeType::f64;
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

// What of the options lets a reader leave out points that the filter would drop, or be faster.
ReadHints hints_of(const CloudOptions& options) {
  return {.crop = options.crop, .resolution = options.resolution, .threads = options.threads};
}

Status check_file(const FileInfo& file, const CloudOptions& options) {
  if (file.dimension < options.dimension)
    return error(Errc::bad_input,
                 file.path.string() + ": holds x and y only, and a 3D cloud was asked for (see --dim)");
  if (options.resolution > 0 && !file.levels)
    return error(Errc::usage,
                 file.path.string() + ": is not COPC, so it has no levels for --resolution to choose from");
  if (options.classes.empty()) return success();
  const auto is_class = [](const Attribute& a) { return a.name == "classification"; };
  if (std::none_of(file.attributes.begin(), file.attributes.end(), is_class))
    return error(Errc::usage, file.path.string() + ": has no classification, so --class cannot choose from it");
  return success();
}

}  // namespace

Result<Cloud> Cloud::open(const std::vector<std::string>& patterns, CloudOptions options) {
  if (options.dimension != 2 && options.dimension != 3) return error(Errc::usage, "the dimension must be 2 or 3");
  if (patterns.empty()) return error(Errc::usage, "no input file was given");
  Cloud cloud;
  std::vector<Attribute> available;
  bool has_z = false;
  for (const auto& pattern : patterns) {
    BOOST_OUTCOME_TRY(paths, expand(pattern));
    for (const auto& path : paths) {
      BOOST_OUTCOME_TRY(reader, open_reader(path, {}, hints_of(options)));
      BOOST_OUTCOME_TRYV(check_file(reader->info(), options));
      add_available(reader->info(), available);
      has_z = has_z || reader->info().dimension == 3;
      cloud.files_.push_back(reader->info());
    }
  }
  if (options.dimension == 2 && has_z) available.push_back({"z", AttributeType::f64});
  BOOST_OUTCOME_TRY(schema, choose(options.attributes, available));
  cloud.schema_ = std::move(schema);
  cloud.options_ = std::move(options);
  return cloud;
}

Result<Cloud> Cloud::open_source(OpenSource source, CloudOptions options) {
  Cloud cloud;
  BOOST_OUTCOME_TRY(reader, open_reader(source(), {}, hints_of(options)));
  BOOST_OUTCOME_TRYV(check_file(reader->info(), options));
  BOOST_OUTCOME_TRY(schema, choose(options.attributes, reader->info().attributes));
  cloud.source_ = std::move(source);
  cloud.files_.push_back(reader->info());
  cloud.schema_ = std::move(schema);
  cloud.options_ = std::move(options);
  return cloud;
}

std::string Cloud::crs() const {
  for (const auto& file : files_)
    if (!file.crs.empty()) return file.crs;
  return "";
}

Result<std::unique_ptr<PointReader>> Cloud::reopen(const FileInfo& file, const std::vector<Attribute>& schema) const {
  BOOST_OUTCOME_TRY(reader, source_ ? open_reader(source_(), schema, hints_of(options_))
                                    : open_reader(file.path, schema, hints_of(options_)));
  // The partition was planned from the first look at the file; another content would be routed by a wrong plan.
  if (reader->info().bytes != file.bytes || reader->info().modified_ns != file.modified_ns)
    return error(Errc::bad_input, file.path.string() + ": was changed by another program while it was read");
  return std::move(reader);
}

Result<CloudCounts> Cloud::for_each_batch(const std::function<Status(CloudBatch&)>& visit) const {
  const PointFilter filter(options_, schema_);
  CloudCounts counts;
  PointBatch batch;
  CloudBatch kept;
  for (const auto& file : files_) {
    BOOST_OUTCOME_TRY(reader, reopen(file, filter.reader_schema()));
    while (true) {
      batch.passed_over = 0;
      BOOST_OUTCOME_TRYV(reader->next(batch));
      counts.read += batch.passed_over;
      counts.filtered += batch.passed_over;
      if (batch.points.empty()) break;
      kept.points.clear();
      kept.rows.clear();
      BOOST_OUTCOME_TRYV(filter.apply(batch, *reader, counts.read, kept, counts));
      if (!kept.points.empty()) {
        BOOST_OUTCOME_TRYV(visit(kept));
      }
    }
  }
  return counts;
}

}  // namespace tessera
