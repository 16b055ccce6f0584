#include "src/input/remote/s3_writer.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/on_threads.h"
#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/input/remote/http_object.h"
#include "src/input/remote/persistence.h"

namespace tessera::remote {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::uint64_t parts_max = 10'000;
constexpr std::size_t answer_bytes_max = std::size_t{64} << 10;

bool is_good(const HttpReply& reply) { return reply.status >= 200 && reply.status < 300 && reply.failure.empty(); }

Error refused_write(const HttpReply& reply, const std::string& name) {
  const std::string shown = printable(name);
  const std::string tries = reply.passing ? ", also after " + std::to_string(tries_max) + " tries" : "";
  if (reply.status == 0) return error(Errc::io, shown + ": there is no answer: " + reply.failure + tries);
  if (reply.status >= 300) return error(Errc::io, shown + ": " + sentence_of_status(reply, true));
  if (!reply.failure.empty()) return error(Errc::io, shown + ": the answer is cut off: " + reply.failure + tries);
  const std::string code = code_of_store(reply);
  return error(Errc::io,
               shown + ": the server does not say that the object is written" + (code.empty() ? "" : ", but " + code));
}

std::string_view text_of(const HttpReply& reply) {
  return {reinterpret_cast<const char*>(reply.body.data()), reply.body.size()};
}

// The text of an element of an answer; empty when there is none.
std::string element(const HttpReply& reply, const std::string& name) {
  const std::string_view text = text_of(reply);
  const std::string open = "<" + name + ">", close = "</" + name + ">";
  const auto begin = text.find(open);
  if (begin == std::string_view::npos) return "";
  const auto end = text.find(close, begin);
  if (end == std::string_view::npos) return "";
  return std::string(text.substr(begin + open.size(), end - begin - open.size()));
}

// What a server says becomes part of a text in XML.
bool is_etag(std::string_view text) {
  return !text.empty() && text.size() <= 256 && std::all_of(text.begin(), text.end(), [](char c) {
    return c > ' ' && c < 0x7F && c != '<' && c != '&' && c != '>';
  });
}

std::uint64_t bytes_of_part(std::uint64_t bytes) { return std::max(part_bytes, (bytes + parts_max - 1) / parts_max); }

Error was_interrupted() { return error(Errc::interrupted, "interrupted while objects were written"); }

}  // namespace

Result<HttpRequest> S3Writer::request_of(const std::string& name, const Ask& ask) {
  const std::lock_guard lock(mutex_);
  BOOST_OUTCOME_TRY(url, s3_address(name, access_));
  Asking asking = access_.asking();
  asking.headers.insert(asking.headers.end(), ask.headers.begin(), ask.headers.end());
  return HttpRequest{.address = url.address + (ask.parameters.empty() ? "" : "?" + ask.parameters),
                     .range = {},
                     .method = ask.method,
                     .body = ask.body,
                     .headers = std::move(asking.headers),
                     .signing = std::move(asking.signing),
                     .region = std::move(asking.region),
                     .bytes_max = answer_bytes_max};
}

Result<HttpReply> S3Writer::send(const std::string& name, const Ask& ask, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(request, request_of(name, ask));
  auto replies = persistently(*transfers_, {request}, printable(name), stop);
  if (!replies && replies.error().code == Errc::interrupted) return was_interrupted();
  if (!replies) return replies.error();
  if (!turn_to_other_region(request, replies.value().front())) return std::move(replies.value().front());
  {
    const std::lock_guard lock(mutex_);
    access_.region = request.region;
  }
  auto again = persistently(*transfers_, {request}, printable(name), stop);
  if (!again && again.error().code == Errc::interrupted) return was_interrupted();
  if (!again) return again.error();
  return std::move(again.value().front());
}

Result<std::string> S3Writer::begin_parts(const std::string& name, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(reply, send(name, {.method = "POST", .parameters = "uploads="}, stop));
  if (!is_good(reply)) return refused_write(reply, name);
  std::string id = element(reply, "UploadId");
  if (id.empty()) return error(Errc::io, printable(name) + ": the server does not say how to send the object in parts");
  return id;
}

void S3Writer::give_up(const std::vector<std::pair<std::string, std::string>>& names_and_ids) {
  std::vector<HttpRequest> requests;
  for (const auto& [name, id] : names_and_ids) {
    auto request = request_of(name, {.method = "DELETE", .parameters = "uploadId=" + as_parameter(id)});
    if (request) requests.push_back(std::move(request).value());
  }
  if (requests.empty()) return;
  // After an interrupt, too: otherwise the parts would stay, and cost money.
  const auto ignored = transfers_->run(requests, {});
  static_cast<void>(ignored);
}

Result<bool> S3Writer::has(const std::string& name, const Bytes& bytes, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(request, request_of(name, {.method = "GET", .parameters = {}}));
  request.bytes_max = bytes.size();
  BOOST_OUTCOME_TRY(replies, persistently(*transfers_, {request}, printable(name), stop));
  return replies.front().status == 200 && replies.front().failure.empty() && replies.front().body == bytes;
}

Result<std::uint64_t> S3Writer::bytes_of(const std::string& name, const std::stop_token& stop) {
  S3Access access;
  {
    const std::lock_guard lock(mutex_);
    access = access_;
  }
  BOOST_OUTCOME_TRY(url, s3_address(name, access));
  BOOST_OUTCOME_TRY(opened, open_http(url, access.asking(), transfers_, 1, stop));
  return opened.object->size();
}

Status S3Writer::remove(const std::string& name, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(reply, send(name, {.method = "DELETE", .parameters = {}}, stop));
  if (is_good(reply) || (reply.status == 404 && code_of_store(reply) != "NoSuchBucket")) return success();
  auto refused = refused_write(reply, name);
  refused.where += "; it was to be removed";
  return refused;
}

Status S3Writer::check_writable(const std::string& name, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(id, begin_parts(name, stop));
  give_up({{name, id}});
  return success();
}

// Writes many objects.
class S3Writer::Putting {
 public:
  Putting(S3Writer& writer, std::span<const NewObject> objects, const std::function<void(std::uint64_t)>& told,
          const std::stop_token& stop)
      : writer_(writer), objects_(objects), told_(told), stop_(stop), uploads_(objects.size()) {
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const std::uint64_t bytes = objects[i].bytes, part = bytes_of_part(bytes);
      uploads_[i].left = bytes <= part_bytes ? 1 : (bytes + part - 1) / part;
      uploads_[i].etags.resize(uploads_[i].left);
      for (std::uint64_t at = 0; at < uploads_[i].left; ++at) pieces_.push_back({i, at});
    }
  }

  Status run() {
    std::atomic<bool> failed = false;
    std::atomic<std::size_t> next = 0;
    const auto threads = static_cast<unsigned>(std::clamp<std::size_t>(pieces_.size(), 1, in_flight_max));
    const Status done = on_threads(threads, failed, [&]() -> Status {
      for (std::size_t k = next++; k < pieces_.size() && !failed; k = next++) {
        BOOST_OUTCOME_TRYV(put(pieces_[k]));
      }
      return success();
    });
    if (done) return done;
    std::vector<std::pair<std::string, std::string>> begun;
    for (std::size_t i = 0; i < objects_.size(); ++i)
      if (!uploads_[i].id.empty() && !uploads_[i].whole) begun.emplace_back(objects_[i].name, uploads_[i].id);
    writer_.give_up(begun);
    return done;
  }

 private:
  struct Piece {
    std::size_t object = 0;
    std::uint64_t part = 0;
  };
  struct Upload {
    std::mutex mutex;  // guards the others
    std::string id;    // of an upload in parts
    std::vector<std::string> etags;
    std::uint64_t left = 1;  // parts that are not yet there
    bool whole = false;
  };

  Status put(const Piece& piece) {
    const NewObject& object = objects_[piece.object];
    if (stop_.stop_requested()) return was_interrupted();
    const bool in_parts = object.bytes > part_bytes;
    const std::uint64_t size = in_parts ? bytes_of_part(object.bytes) : object.bytes, begin = piece.part * size;
    const auto body = std::make_shared<Bytes>(static_cast<std::size_t>(std::min(size, object.bytes - begin)));
    BOOST_OUTCOME_TRYV(object.read(begin, *body));
    if (in_parts) {
      BOOST_OUTCOME_TRYV(put_part(object, uploads_[piece.object], piece.part, body));
    } else {
      BOOST_OUTCOME_TRYV(put_whole(object, body));
    }
    told_(body->size());
    return success();
  }

  Status put_whole(const NewObject& object, const std::shared_ptr<const Bytes>& body) {
    Ask ask{.method = "PUT", .parameters = {}, .headers = {}, .body = body};
    if (object.only_new) ask.headers.push_back("If-None-Match: *");
    BOOST_OUTCOME_TRY(reply, writer_.send(object.name, ask, stop_));
    if (object.only_new && reply.status == 501) {  // the server does not know the header
      ask.headers.clear();
      BOOST_OUTCOME_TRY(again, writer_.send(object.name, ask, stop_));
      reply = std::move(again);
    }
    if (is_good(reply)) return success();
    if (object.only_new && (reply.status == 412 || reply.status == 409)) {
      // It may have been written by an earlier try, whose answer was lost.
      BOOST_OUTCOME_TRY(ours, writer_.has(object.name, *body, stop_));
      if (ours) return success();
      return error(Errc::usage, printable(object.name) + ": was written by another program meanwhile; " +
                                    option("overwrite", "true") + " replaces it");
    }
    return refused_write(reply, object.name);
  }

  Status put_part(const NewObject& object, Upload& upload, std::uint64_t part,
                  const std::shared_ptr<const Bytes>& body) {
    std::string id;
    {
      const std::lock_guard lock(upload.mutex);
      if (upload.id.empty()) {
        BOOST_OUTCOME_TRY(begun, writer_.begin_parts(object.name, stop_));
        upload.id = std::move(begun);
      }
      id = upload.id;
    }
    const std::string parameters = "partNumber=" + std::to_string(part + 1) + "&uploadId=" + as_parameter(id);
    BOOST_OUTCOME_TRY(
        reply,
        writer_.send(object.name, {.method = "PUT", .parameters = parameters, .headers = {}, .body = body}, stop_));
    if (!is_good(reply)) return refused_write(reply, object.name);
    const std::string& etag = header(reply, "etag");
    if (!is_etag(etag)) return error(Errc::io, printable(object.name) + ": the server gives a part of it no ETag");
    const std::lock_guard lock(upload.mutex);
    upload.etags[static_cast<std::size_t>(part)] = etag;
    if (--upload.left > 0) return success();
    BOOST_OUTCOME_TRYV(complete(object, upload));
    upload.whole = true;
    return success();
  }

  // REQUIRES: the upload's mutex is held.
  Status complete(const NewObject& object, const Upload& upload) {
    std::string text = "<CompleteMultipartUpload xmlns=\"http://s3.amazonaws.com/doc/2006-03-01/\">";
    for (std::size_t i = 0; i < upload.etags.size(); ++i)
      text += "<Part><PartNumber>" + std::to_string(i + 1) + "</PartNumber><ETag>" + upload.etags[i] + "</ETag></Part>";
    text += "</CompleteMultipartUpload>";
    const auto bytes = std::as_bytes(std::span(text));
    BOOST_OUTCOME_TRY(reply, writer_.send(object.name,
                                          {.method = "POST",
                                           .parameters = "uploadId=" + as_parameter(upload.id),
                                           .headers = {},
                                           .body = std::make_shared<const Bytes>(bytes.begin(), bytes.end())},
                                          stop_));
    // A store may find out that it cannot, when it has already said 200.
    if (is_good(reply) && text_of(reply).find("<CompleteMultipartUploadResult") != std::string_view::npos)
      return success();
    if (reply.status != 404) return refused_write(reply, object.name);
    // It may have been completed by an earlier try, whose answer was lost.
    BOOST_OUTCOME_TRY(there, writer_.bytes_of(object.name, stop_));
    if (there == object.bytes) return success();
    return refused_write(reply, object.name);
  }

  S3Writer& writer_;
  std::span<const NewObject> objects_;
  const std::function<void(std::uint64_t)>& told_;
  const std::stop_token& stop_;
  std::vector<Upload> uploads_;  // by object
  std::vector<Piece> pieces_;
};

Status S3Writer::put(std::span<const NewObject> objects, const std::function<void(std::uint64_t)>& told,
                     const std::stop_token& stop) {
  return Putting(*this, objects, told, stop).run();
}

}  // namespace tessera::remote
