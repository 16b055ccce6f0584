#include "src/input/remote/remote_objects.h"

#include <algorithm>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/input/bytes/far_source.h"
#include "src/input/remote/http_object.h"
#include "src/input/remote/kept_pages.h"
#include "src/input/remote/kept_source.h"
#include "src/input/remote/s3.h"
#include "src/input/remote/s3_listing.h"
#include "src/input/remote/s3_writer.h"
#include "src/input/remote/stac.h"
#include "src/input/remote/transfers.h"
#include "src/input/remote/url.h"
#include "src/input/remote/vsi_objects.h"

namespace tessera::remote {
namespace {

// Enough for the header of most LAS files, and for what tells other formats.
constexpr std::size_t begin_bytes = std::size_t{16} << 10;
// Of an object that is wanted as a whole.
constexpr std::size_t piece_bytes = std::size_t{1} << 20, pieces_at_once = 8;
constexpr std::size_t stac_document_bytes_max = std::size_t{16} << 20;
constexpr std::size_t stac_documents_max = 10'000, stac_files_max = 100'000;

class RemoteObjects : public Objects, public std::enable_shared_from_this<RemoteObjects> {
 public:
  explicit RemoteObjects(RemoteOptions options)
      : pages_(std::make_shared<KeptPages>(std::move(options.folder), options.kept_bytes_max)),
        s3_options_(std::move(options.s3)),
        ca_file_(std::move(options.ca_file)),
        permits_(std::move(options.permits)) {}

  Result<std::shared_ptr<const ByteSource>> open(const std::string& name, std::stop_token stop) override {
    return open_first(name, begin_bytes, stop);
  }

  Result<std::vector<std::string>> names(const std::string& name, bool recursive, std::stop_token stop) override {
    BOOST_OUTCOME_TRYV(permitted(name));
    if (is_of_gdal(name) && name.ends_with('/')) return list_of_gdal(name, recursive);
    if (is_of_gdal(name)) return std::vector{name};
    if (is_stac_name(name)) return stac_files(name, recursive, stop);
    if (!is_s3(name) || (!name.ends_with('/') && name.find('/', 5) != std::string::npos)) return std::vector{name};
    BOOST_OUTCOME_TRY(access, s3_access());
    return list_s3(name, recursive, access, *transfers(), stop);
  }

  Status copy(const std::string& name, ObjectTaker& to, std::stop_token stop) override {
    if (is_of_gdal(name))
      return error(Errc::usage, printable(name) +
                                    ": results are read from https://, http:// and s3://, not from "
                                    "stores that GDAL reads");
    BOOST_OUTCOME_TRY(place, place_of(name));
    BOOST_OUTCOME_TRY(opened, open_http(place.url, std::move(place.asking), transfers(), piece_bytes, std::move(stop)));
    const std::uint64_t size = opened.object->size();
    BOOST_OUTCOME_TRYV(to.begin(size));
    BOOST_OUTCOME_TRYV(to.take(opened.begin));
    std::uint64_t at = opened.begin.size();
    while (at < size) {
      std::vector<ByteRange> ranges;
      for (; at < size && ranges.size() < pieces_at_once; at = ranges.back().end)
        ranges.push_back({at, std::min<std::uint64_t>(at + piece_bytes, size)});
      BOOST_OUTCOME_TRY(pieces, opened.object->read(ranges));
      for (const auto& piece : pieces) {
        BOOST_OUTCOME_TRYV(to.take(piece));
      }
    }
    return success();
  }

  Result<bool> exists(const std::string& name, std::stop_token stop) override {
    if (is_of_gdal(name)) return false;  // no results are read from there
    BOOST_OUTCOME_TRY(place, place_of(name));
    return http_exists(place.url, std::move(place.asking), *transfers(), stop);
  }

  Status put(std::span<const NewObject> objects, const std::function<void(std::uint64_t)>& told,
             std::stop_token stop) override {
    for (const NewObject& object : objects) {
      BOOST_OUTCOME_TRYV(check_store(object.name));
    }
    BOOST_OUTCOME_TRY(writer, s3_writer());
    return writer->put(objects, told, stop);
  }

  Status check_writable(const std::string& name, std::stop_token stop) override {
    BOOST_OUTCOME_TRYV(check_store(name));
    BOOST_OUTCOME_TRY(writer, s3_writer());
    return writer->check_writable(name, stop);
  }

  Status remove(const std::string& name, std::stop_token stop) override {
    BOOST_OUTCOME_TRYV(check_store(name));
    BOOST_OUTCOME_TRY(writer, s3_writer());
    return writer->remove(name, stop);
  }

 private:
  static Status check_store(const std::string& name) {
    if (is_s3(name)) return success();
    return error(Errc::usage, without_secrets(name) + ": of objects only those of s3:// can be written");
  }

  struct Place {
    Url url;
    Asking asking;
  };
  Result<Place> place_of(const std::string& name) {
    if (!is_s3(name)) {
      BOOST_OUTCOME_TRY(url, parse_url(name));
      return Place{std::move(url), {}};
    }
    BOOST_OUTCOME_TRYV(permitted(name));
    BOOST_OUTCOME_TRY(access, s3_access());
    BOOST_OUTCOME_TRY(url, s3_address(name, access));
    return Place{std::move(url), access.asking()};
  }

  // Opens an object, and asks for its first bytes.
  Result<std::shared_ptr<const ByteSource>> open_first(const std::string& name, std::size_t first_bytes,
                                                       const std::stop_token& stop) {
    OpenedObject opened;
    if (is_of_gdal(name)) {
      BOOST_OUTCOME_TRYV(permitted(name));
      BOOST_OUTCOME_TRY(object, open_of_gdal(name, stop));
      opened.object = std::move(object);
    } else {
      BOOST_OUTCOME_TRY(place, place_of(name));
      BOOST_OUTCOME_TRY(got, open_http(place.url, std::move(place.asking), transfers(), first_bytes, stop));
      opened = std::move(got);
    }
    const auto beside = [self = shared_from_this(), stop](const std::string& other, std::size_t bytes) {
      return self->open_first(other, bytes, stop);
    };
    BOOST_OUTCOME_TRY(source, keep_source(std::move(opened.object), std::move(opened.begin), pages_, beside));
    return std::shared_ptr<const ByteSource>(std::move(source));
  }

  // Whether this process may ask for what a name means.
  Status permitted(const std::string& name) const {
    if (!permits_) return success();
    if (is_of_gdal(name)) return error(Errc::usage, printable(name) + ": a service does not read gs:// and az://");
    if (is_s3(name)) return permits_->check_s3(name);
    return permits_->check_address(name, without_secrets(name));
  }

  // Whether it may ask for all that a document names.
  Status permitted(const StacDocument& document, bool recursive) const {
    for (const auto* names : {&document.files, &document.documents, &document.below}) {
      if (names == &document.below && !recursive) continue;
      for (const auto& name : *names) {
        BOOST_OUTCOME_TRYV(permitted(name));
      }
    }
    return success();
  }

  // The point files of a document of STAC and of those to which it leads, sorted, each once.
  Result<std::vector<std::string>> stac_files(const std::string& name, bool recursive, const std::stop_token& stop) {
    std::set<std::string> files, seen{name};
    std::vector<std::string> open{name};
    const auto refuse = [&](const std::string& what) {
      return error(Errc::bad_input, without_secrets(name) + ": " + what);
    };
    const auto add = [&](const std::vector<std::string>& documents) {
      for (const auto& document : documents)
        if (seen.insert(document).second) open.push_back(document);
    };
    while (!open.empty()) {
      const std::string document = std::move(open.back());
      open.pop_back();
      BOOST_OUTCOME_TRY(place, place_of(document));
      BOOST_OUTCOME_TRY(bytes,
                        get_http(place.url, std::move(place.asking), *transfers(), stac_document_bytes_max, stop));
      const auto parsed = parse_stac(as_text(bytes), document);
      if (parsed.has_error())
        return error(parsed.error().code, without_secrets(document) + ": " + parsed.error().where);
      const Status allowed = permitted(parsed.value(), recursive);
      if (allowed.has_error())
        return error(allowed.error().code, without_secrets(document) + ": names " + allowed.error().where);
      files.insert(parsed.value().files.begin(), parsed.value().files.end());
      add(parsed.value().documents);
      if (recursive) add(parsed.value().below);
      if (seen.size() > stac_documents_max || files.size() > stac_files_max)
        return refuse("leads to more than " + std::to_string(stac_documents_max) + " documents, or names more than " +
                      std::to_string(stac_files_max) + " files");
    }
    if (files.empty())
      return refuse(
          "names no point files; in STAC these are assets whose type or name is that of a format that can be "
          "read, and " +
          option("recursive", "true") + " looks into catalogs below, too");
    return std::vector<std::string>(files.begin(), files.end());
  }

  std::shared_ptr<Transfers> transfers() {
    const std::lock_guard lock(mutex_);
    if (!transfers_) transfers_ = std::make_shared<Transfers>(Patience{}, ca_file_, permits_);
    return transfers_;
  }

  Result<std::shared_ptr<S3Writer>> s3_writer() {
    BOOST_OUTCOME_TRY(access, s3_access());
    auto requests = transfers();
    const std::lock_guard lock(mutex_);
    if (!writer_) writer_ = std::make_shared<S3Writer>(std::move(access), std::move(requests));
    return writer_;
  }

  // Found once: the variables and files of this process do not change.
  Result<S3Access> s3_access() {
    const std::lock_guard lock(mutex_);
    if (!s3_access_) s3_access_ = find_s3_access(s3_options_, [](const char* name) { return std::getenv(name); });
    return *s3_access_;
  }

  std::shared_ptr<KeptPages> pages_;
  S3Options s3_options_;
  std::string ca_file_;
  std::shared_ptr<const Permits> permits_;
  std::optional<Result<S3Access>> s3_access_;
  std::mutex mutex_;
  std::shared_ptr<Transfers> transfers_;
  std::shared_ptr<S3Writer> writer_;
};

}  // namespace

std::string ca_file_of(const std::function<const char*(const char*)>& variable) {
  std::string file;
  for (const char* name : {"SSL_CERT_FILE", "CURL_CA_BUNDLE"})  // the last one counts
    if (const char* named = variable(name)) file = named;
  return file;
}

std::shared_ptr<Objects> remote_objects(RemoteOptions options) {
  return std::make_shared<RemoteObjects>(std::move(options));
}

}  // namespace tessera::remote
