#include "src/input/remote/vsi_objects.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <utility>

#include "src/base/crs/gdal_files.h"
#include "src/base/crs/gdal_library.h"
#include "src/base/on_threads.h"
#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/input/format.h"
#include "src/input/remote/transfers.h"

namespace tessera::remote {
namespace {

// What of GDAL is used here.
struct Gdal {
  const GdalLibrary& library;
  const GdalFiles& files;
};

// Until destroyed, GDAL is quiet on this thread, waits for servers as Transfers does, and keeps no answer: a version of
// an object must not be mixed with what was kept of another one.
class GdalManners {
 public:
  explicit GdalManners(const Gdal& gdal) : gdal_(gdal.library), quiet_(gdal.library) {
    for (const auto& [name, value] : settings) gdal_.CPLSetThreadLocalConfigOption(name, value);
  }
  ~GdalManners() {
    for (const auto& [name, value] : settings) gdal_.CPLSetThreadLocalConfigOption(name, nullptr);
  }
  GdalManners(const GdalManners&) = delete;
  GdalManners& operator=(const GdalManners&) = delete;
  std::string message() const { return printable(quiet_.message()); }

 private:
  struct Setting {
    const char *name, *value;
  };
  static constexpr std::array<Setting, 7> settings{{{"CPL_VSIL_CURL_NON_CACHED", "/vsigs/:/vsiaz/"},
                                                    {"GDAL_HTTP_CONNECTTIMEOUT", "10"},
                                                    {"GDAL_HTTP_TIMEOUT", "300"},
                                                    {"GDAL_HTTP_LOW_SPEED_TIME", "20"},
                                                    {"GDAL_HTTP_LOW_SPEED_LIMIT", "1024"},
                                                    {"GDAL_HTTP_MAX_RETRY", "4"},
                                                    {"GDAL_HTTP_RETRY_DELAY", "0.2"}}};

  const GdalLibrary& gdal_;
  const GdalQuiet quiet_;
};

std::string path_of_gdal(const std::string& name) {
  return (name.starts_with("gs://") ? "/vsigs/" : "/vsiaz/") + name.substr(5);
}

struct LengthAndTime {
  std::uint64_t size = 0;
  std::int64_t modified_s = 0;
  friend bool operator==(const LengthAndTime&, const LengthAndTime&) = default;
};

Result<LengthAndTime> look_at_object(const Gdal& gdal, const std::string& name) {
  const GdalManners manners(gdal);
  const std::string path = path_of_gdal(name);
  gdal.files.VSICurlPartialClearCache(path.c_str());
  VSIStatBufL found{};
  if (gdal.files.VSIStatExL(path.c_str(), &found, VSI_STAT_EXISTS_FLAG | VSI_STAT_NATURE_FLAG | VSI_STAT_SIZE_FLAG) !=
      0)
    return error(Errc::io, printable(name) + ": there is no such object, or it must not be read: " + manners.message());
  if (VSI_ISDIR(found.st_mode))
    return error(Errc::bad_input, printable(name) + ": is a folder, whose name ends with '/'");
  return LengthAndTime{static_cast<std::uint64_t>(found.st_size), static_cast<std::int64_t>(found.st_mtime)};
}

class ObjectOfGdal : public RangeReader {
 public:
  ObjectOfGdal(const Gdal& gdal, const std::string& name, const LengthAndTime& version, std::stop_token stop)
      : gdal_(gdal), name_(name), shown_(printable(name)), version_(version), stop_(std::move(stop)) {}
  ObjectOfGdal(const ObjectOfGdal&) = delete;
  ObjectOfGdal& operator=(const ObjectOfGdal&) = delete;
  ~ObjectOfGdal() override {
    for (VSILFILE* file : idle_) static_cast<void>(gdal_.files.VSIFCloseL(file));
  }

  const std::string& name() const override { return shown_; }
  std::uint64_t size() const override { return version_.size; }
  std::int64_t modified_ns() const override { return version_.modified_s * 1'000'000'000; }

  Result<std::vector<std::vector<std::byte>>> read(std::span<const ByteRange> ranges) const override {
    std::vector<std::vector<std::byte>> bytes(ranges.size());
    std::atomic<std::size_t> next{0};
    std::atomic<bool> failed{false};
    const auto read_some = [&]() -> Status {
      const GdalManners manners(gdal_);
      for (std::size_t i = next++; i < ranges.size() && !failed; i = next++) {
        if (stop_.stop_requested()) return error(Errc::interrupted, "interrupted while " + shown_ + " was read");
        bytes[i].resize(static_cast<std::size_t>(ranges[i].end - ranges[i].begin));
        BOOST_OUTCOME_TRYV(read_range(ranges[i].begin, bytes[i], manners));
      }
      return success();
    };
    const auto threads = std::min<std::size_t>(in_flight_max, ranges.size());
    BOOST_OUTCOME_TRYV(on_threads(static_cast<unsigned>(threads), failed, read_some));
    return bytes;
  }

  // GDAL does not ask for a version, so the object is looked at again.
  Status check_unchanged() const override {
    BOOST_OUTCOME_TRY(now, look_at_object(gdal_, name_));
    if (now == version_) return success();
    return error(Errc::bad_input, shown_ + ": was changed on the server while it was read");
  }

 private:
  Status read_range(std::uint64_t offset, std::span<std::byte> out, const GdalManners& manners) const {
    VSILFILE* file = take();
    if (file == nullptr) file = gdal_.files.VSIFOpenL(path_of_gdal(name_).c_str(), "rb");
    if (file == nullptr) return error(Errc::io, shown_ + ": cannot be opened: " + manners.message());
    const bool whole = gdal_.files.VSIFSeekL(file, offset, SEEK_SET) == 0 &&
                       gdal_.files.VSIFReadL(out.data(), 1, out.size(), file) == out.size();
    if (whole) {
      give_back(file);
      return success();
    }
    static_cast<void>(gdal_.files.VSIFCloseL(file));
    return error(Errc::io, shown_ + ": " + std::to_string(out.size()) + " bytes from " + std::to_string(offset) +
                               " on cannot be read: " + manners.message());
  }

  VSILFILE* take() const {
    const std::lock_guard lock(mutex_);
    if (idle_.empty()) return nullptr;
    VSILFILE* file = idle_.back();
    idle_.pop_back();
    return file;
  }
  void give_back(VSILFILE* file) const {
    const std::lock_guard lock(mutex_);
    idle_.push_back(file);
  }

  const Gdal gdal_;
  std::string name_, shown_;
  LengthAndTime version_;
  std::stop_token stop_;
  mutable std::mutex mutex_;
  mutable std::vector<VSILFILE*> idle_;  // a handle serves one thread at a time
};

Result<Gdal> gdal_for(const std::string& name) {
  const auto library = gdal_library();
  const auto files = gdal_files();
  if (files.has_error())
    return error(Errc::io, printable(name) + ": " + name.substr(0, 5) + " is read by GDAL: " + files.error().where);
  return Gdal{*library.value(), *files.value()};
}

}  // namespace

bool is_of_gdal(const std::string& name) { return name.starts_with("gs://") || name.starts_with("az://"); }

Result<std::unique_ptr<RangeReader>> open_of_gdal(const std::string& name, std::stop_token stop) {
  BOOST_OUTCOME_TRY(gdal, gdal_for(name));
  BOOST_OUTCOME_TRY(version, look_at_object(gdal, name));
  if (version.size == 0) return error(Errc::bad_input, printable(name) + ": is empty");
  return std::unique_ptr<RangeReader>(new ObjectOfGdal(gdal, name, version, std::move(stop)));
}

Result<std::vector<std::string>> list_of_gdal(const std::string& name, bool recursive) {
  constexpr int names_max = 1'000'000;
  BOOST_OUTCOME_TRY(gdal, gdal_for(name));
  const GdalManners manners(gdal);
  std::string path = path_of_gdal(name);
  while (path.ends_with('/')) path.pop_back();
  char** found =
      recursive ? gdal.files.VSIReadDirRecursive(path.c_str()) : gdal.files.VSIReadDirEx(path.c_str(), names_max);
  std::vector<std::string> names;
  const std::string folder = name.ends_with('/') ? name : name + "/";
  for (char** each = found; each != nullptr && *each != nullptr; ++each)
    if (has_point_file_name(*each)) names.push_back(folder + *each);
  gdal.library.CSLDestroy(found);
  if (names.empty())
    return error(Errc::io, printable(name) + ": holds no point files (" + point_file_endings() +
                               ", and these with .gz or .zst), or must not be listed" +
                               (recursive ? "" : "; " + option("recursive", "true") + " looks into its folders, too"));
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace tessera::remote
