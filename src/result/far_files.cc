#include "src/result/far_files.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "src/base/files/mapped_file.h"
#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/bytes/objects.h"

namespace tessera::result {

namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t copies_bytes_max = std::uint64_t{1} << 30;
constexpr std::size_t copies_max = 128;
constexpr std::uint64_t manifest_bytes_max = std::uint64_t{256} << 20;

Error other_size(const fs::path& name, std::uint64_t bytes, std::uint64_t told) {
  return error(Errc::corrupt, name.string() + ": has " + std::to_string(bytes) + " bytes, but the manifest says " +
                                  std::to_string(told) + ": the result was replaced while it was read, or is damaged");
}

class IntoMemory : public ObjectTaker {
 public:
  explicit IntoMemory(const fs::path& name) : name_(name) {}
  Status begin(std::uint64_t bytes) override {
    if (bytes > manifest_bytes_max)
      return error(Errc::corrupt,
                   name_.string() + ": has " + std::to_string(bytes) + " bytes, too many for a manifest");
    return success();
  }
  Status take(std::span<const std::byte> bytes) override {
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return success();
  }
  std::vector<std::byte> bytes() && { return std::move(bytes_); }

 private:
  const fs::path& name_;
  std::vector<std::byte> bytes_;
};

class IntoFile : public ObjectTaker {
 public:
  IntoFile(const fs::path& name, std::uint64_t told) : name_(name), told_(told) {}
  Status begin(std::uint64_t bytes) override {
    if (bytes != told_) return other_size(name_, bytes, told_);
    BOOST_OUTCOME_TRY(place, folder_for_temporary());
    BOOST_OUTCOME_TRY(file, nameless_file(place));
    file_ = std::move(file);
    place_ = std::move(place);
    return success();
  }
  Status take(std::span<const std::byte> bytes) override {
    BOOST_OUTCOME_TRYV(write_at(file_.get(), bytes, written_, place_, "cannot keep there what was fetched"));
    written_ += bytes.size();
    return success();
  }
  FileHandle file() && { return std::move(file_); }

 private:
  const fs::path& name_;
  std::uint64_t told_, written_ = 0;
  fs::path place_;
  FileHandle file_;
};

std::uint64_t sum_of(std::span<const std::byte> bytes, ChecksumOf what) {
  if (what == ChecksumOf::bytes) return checksum(bytes);
  std::vector<std::uint64_t> sums;
  for (std::size_t at = 0; at < bytes.size(); at += sum_piece_bytes)
    sums.push_back(checksum(bytes.subspan(at, std::min(sum_piece_bytes, bytes.size() - at))));
  return checksum(std::as_bytes(std::span(sums)));
}

Result<FileHandle> fetch(const fs::path& name, const ToldFile& told, const std::stop_token& stop) {
  IntoFile taker(name, told.bytes);
  BOOST_OUTCOME_TRYV(copy_object(name.string(), taker, stop));
  FileHandle file = std::move(taker).file();
  BOOST_OUTCOME_TRY(mapped, MappedFile::open(file, name));
  const std::uint64_t sum = sum_of(mapped.bytes(), told.sum);
  if (sum == told.xxh3) return file;
  return error(Errc::corrupt, name.string() + ": its checksum is " + checksum_text(sum) + ", but the manifest says " +
                                  checksum_text(told.xxh3) +
                                  ": the result was replaced while it was read, or is damaged");
}

DataFile data_of(const fs::path& name, std::uint64_t bytes, std::shared_ptr<const FileHandle> file) {
  return {name, bytes, [file = std::move(file), name](std::uint64_t offset, std::span<std::byte> out) -> Status {
            BOOST_OUTCOME_TRY(got, read_up_to(file->get(), out, offset, name));
            if (got == out.size()) return success();
            return error(Errc::io, name.string() + ": the copy of it in the temporary folder cannot be read back");
          }};
}

// Unmarks a file as under way, also after an exception. REQUIRES: the mutex is free.
class UnderWay {
 public:
  UnderWay(std::mutex& mutex, std::condition_variable_any& arrived, std::set<std::string>& all, const std::string& name)
      : mutex_(mutex), arrived_(arrived), all_(all), name_(name) {}
  UnderWay(const UnderWay&) = delete;
  UnderWay& operator=(const UnderWay&) = delete;
  ~UnderWay() {
    {
      const std::lock_guard lock(mutex_);
      all_.erase(name_);
    }
    arrived_.notify_all();
  }

 private:
  std::mutex& mutex_;
  std::condition_variable_any& arrived_;
  std::set<std::string>& all_;
  const std::string& name_;
};

}  // namespace

bool is_far(const fs::path& path) { return names_object(path.string()); }

Status refuse_far(const fs::path& out) {
  if (!is_far(out)) return success();
  return error(Errc::usage,
               out.string() + ": a result in an object store cannot be changed there; copy it into a folder first");
}

Result<std::vector<std::byte>> read_far_text(const fs::path& out) {
  if (out.string().find_first_of("?#") != std::string::npos)
    return error(Errc::usage, out.string().substr(0, out.string().find_first_of("?#")) +
                                  ": the address of a result has no parameters (?), because the names of its files "
                                  "follow");
  const auto path = manifest_file(out);
  IntoMemory taker(path);
  BOOST_OUTCOME_TRYV(copy_object(path.string(), taker, {}));
  return std::move(taker).bytes();
}

Result<Manifest> read_far_manifest(const fs::path& out) {
  BOOST_OUTCOME_TRY(bytes, read_far_text(out));
  return parse_manifest(manifest_file(out), bytes);
}

std::shared_ptr<const FileHandle> FarFiles::find(const std::string& name) {
  const auto found = std::find_if(copies_.begin(), copies_.end(), [&](const Copy& copy) { return copy.name == name; });
  if (found == copies_.end()) return nullptr;
  copies_.splice(copies_.end(), copies_, found);
  return found->file;
}

void FarFiles::keep(Copy copy) {
  bytes_ += copy.bytes;
  copies_.push_back(std::move(copy));
  while (copies_.size() > 1 && (bytes_ > copies_bytes_max || copies_.size() > copies_max)) {
    bytes_ -= copies_.front().bytes;
    copies_.pop_front();
  }
}

Result<DataFile> FarFiles::whole(const fs::path& name, const ToldFile& told, const std::stop_token& stop) {
  const std::string key = name.string();
  {
    std::unique_lock lock(mutex_);
    if (!arrived_.wait(lock, stop, [&] { return !under_way_.contains(key); }))
      return error(Errc::interrupted, "interrupted while " + key + " was read");
    if (auto file = find(key)) return data_of(name, told.bytes, std::move(file));
    under_way_.insert(key);
  }
  const UnderWay marked(mutex_, arrived_, under_way_, key);
  BOOST_OUTCOME_TRY(fetched, fetch(name, told, stop));
  auto file = std::make_shared<const FileHandle>(std::move(fetched));
  const std::lock_guard lock(mutex_);
  keep({key, told.bytes, file});
  return data_of(name, told.bytes, std::move(file));
}

Result<DataFile> FarFiles::ranges(const fs::path& name, std::uint64_t bytes, const std::stop_token& stop) {
  {
    const std::lock_guard lock(mutex_);
    if (auto file = find(name.string())) return data_of(name, bytes, std::move(file));
  }
  BOOST_OUTCOME_TRY(source, open_object(name.string(), stop));
  if (source->size() != bytes) return other_size(name, source->size(), bytes);
  return DataFile(name, bytes, [source = std::move(source)](std::uint64_t offset, std::span<std::byte> out) {
    return source->read(offset, out);
  });
}

}  // namespace tessera::result
