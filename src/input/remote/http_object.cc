#include "src/input/remote/http_object.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/remote/curl_library.h"
#include "src/input/remote/permits.h"
#include "src/input/remote/persistence.h"

namespace tessera::remote {
namespace {

constexpr int redirects_max = 5;

// What a Content-Range says: "bytes 0-16383/146515", where * stands for an unknown length.
struct ContentRange {
  std::uint64_t begin = 0, end = 0;
  std::optional<std::uint64_t> size;
};

std::optional<ContentRange> content_range(std::string_view text) {
  if (!text.starts_with("bytes ")) return {};
  text.remove_prefix(6);
  const auto dash = text.find('-'), slash = text.find('/');
  if (dash == std::string_view::npos || slash == std::string_view::npos || slash < dash) return {};
  const auto first = number_of(text.substr(0, dash)), last = number_of(text.substr(dash + 1, slash - dash - 1));
  if (!first || !last || *last < *first || *last == UINT64_MAX) return {};
  return ContentRange{*first, *last + 1, number_of(text.substr(slash + 1))};
}

std::string range_text(const ByteRange& range) {
  return std::to_string(range.begin) + "-" + std::to_string(range.end - 1);
}

// An answer that has no bytes for the caller, as an error.
std::optional<Error> refusal(const HttpReply& reply, const std::string& name) {
  const auto io = [&](const std::string& what) { return error(Errc::io, name + ": " + what); };
  if (reply.status == 0)
    return io("there is no answer: " + reply.failure +
              (reply.passing ? ", also after " + std::to_string(tries_max) + " tries" : ""));
  if (reply.status == 412) return error(Errc::bad_input, name + ": was changed on the server while it was read");
  if (reply.status == 416) return error(Errc::bad_input, name + ": is empty, or became shorter while it was read");
  if (reply.status == 200)
    return error(Errc::bad_input, name +
                                      ": the server gives only the whole object, not parts of it (it ignores the "
                                      "header Range); download the file, and read that");
  if (reply.status != 206) return io(sentence_of_status(reply));
  if (!reply.failure.empty())
    return io("the answer is cut off: " + reply.failure +
              (reply.passing ? ", also after " + std::to_string(tries_max) + " tries" : ""));
  const std::string& encoding = header(reply, "content-encoding");
  if (!encoding.empty() && encoding != "identity")
    return error(Errc::bad_input, name + ": the server compresses parts of the object (" + printable(encoding) +
                                      ") although it was not asked to");
  return {};
}

// The bytes of an answer to a request for `range`, which must be exactly these.
Result<ContentRange> checked_range(const HttpReply& reply, const ByteRange& range, const std::string& name) {
  if (auto refused = refusal(reply, name)) return std::move(*refused);
  const std::string& text = header(reply, "content-range");
  const auto got = content_range(text);
  if (!got)
    return error(Errc::bad_input, name + ": the answer for bytes " + range_text(range) + " does not say which bytes " +
                                      "it holds; its Content-Range is '" + printable(text) + "'");
  if (got->begin != range.begin || got->end > range.end || reply.body.size() != got->end - got->begin)
    return error(Errc::bad_input, name + ": bytes " + range_text(range) + " were asked for, but the answer says '" +
                                      printable(text) + "' and has " + std::to_string(reply.body.size()) + " bytes");
  return *got;
}

// What tells versions of an object apart.
struct VersionMarks {
  std::string etag, modified;
  std::uint64_t size = 0;

  bool strong() const { return etag.starts_with('"'); }
};

class HttpObject : public RangeReader {
 public:
  // `request`: what each request for a range begins with.
  HttpObject(std::string name, HttpRequest request, VersionMarks version, std::shared_ptr<Transfers> transfers,
             std::stop_token stop)
      : name_(std::move(name)),
        request_(std::move(request)),
        version_(std::move(version)),
        transfers_(std::move(transfers)),
        stop_(std::move(stop)) {}

  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return version_.size; }
  std::int64_t modified_ns() const override {
    const auto curl = curl_library();
    const auto seconds =
        version_.modified.empty() || curl.has_error() ? 0 : curl.value()->getdate(version_.modified.c_str(), nullptr);
    return seconds > 0 ? std::int64_t{seconds} * 1'000'000'000 : 0;
  }

  Result<std::vector<std::vector<std::byte>>> read(std::span<const ByteRange> ranges) const override {
    std::vector<HttpRequest> requests;
    for (const auto& range : ranges) {
      HttpRequest request = request_;
      request.range = range_text(range);
      request.bytes_max = static_cast<std::size_t>(range.end - range.begin);
      if (version_.strong()) request.headers.push_back("If-Match: " + version_.etag);
      requests.push_back(std::move(request));
    }
    BOOST_OUTCOME_TRY(replies, persistently(*transfers_, requests, name_, stop_));
    std::vector<std::vector<std::byte>> bytes;
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      BOOST_OUTCOME_TRY(got, checked_range(replies[i], ranges[i], name_));
      // Not every server and proxy looks at If-Match.
      const bool same = header(replies[i], "etag") == version_.etag && got.size == version_.size &&
                        (!version_.etag.empty() || header(replies[i], "last-modified") == version_.modified);
      if (!same) return error(Errc::bad_input, name_ + ": was changed on the server while it was read");
      if (got.end != ranges[i].end)
        return error(Errc::bad_input, name_ + ": bytes " + range_text(ranges[i]) + " were asked for, but the server " +
                                          "sent only " + std::to_string(replies[i].body.size()));
      bytes.push_back(std::move(replies[i].body));
    }
    return bytes;
  }

 private:
  std::string name_;
  HttpRequest request_;
  VersionMarks version_;
  std::shared_ptr<Transfers> transfers_;
  std::stop_token stop_;
};

bool is_redirect(int status) {
  return status == 301 || status == 302 || status == 303 || status == 307 || status == 308;
}

Result<HttpReply> ask_once(Transfers& transfers, const HttpRequest& request, const std::string& name,
                           const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(replies, persistently(transfers, {request}, name, stop));
  return std::move(replies.front());
}

// Where a redirect leads, if it may be followed.
Result<Url> redirected(const Transfers& transfers, const HttpReply& reply, const HttpRequest& request,
                       const std::string& scheme, int redirects, const std::string& name) {
  const auto refuse = [&](const std::string& what) { return error(Errc::io, name + ": " + what); };
  if (redirects == redirects_max) return refuse("the server leads from one address to the next without end");
  if (reply.redirect.empty()) return refuse("the server leads to another address, but does not say to which");
  const auto next = parse_url(reply.redirect);
  if (next.has_error()) return refuse("the server leads to another address, which is refused: " + next.error().where);
  if (request.signing || !request.headers.empty())
    return refuse("the server leads to " + next.value().shown + ", which must not get what is meant for this one");
  if (scheme == "https" && next.value().scheme != "https")
    return refuse("the server leads from https:// to " + next.value().shown + ", which is not encrypted");
  if (const Permits* permits = transfers.permits()) {
    const Status permitted = permits->check_address(next.value().address, next.value().shown);
    if (permitted.has_error()) return refuse("the server leads to " + permitted.error().where);
  }
  return next.value();
}

// Asks, and follows where the answers lead: to another region of a store, or to another address. Afterwards `request`
// is the one that was answered.
Result<HttpReply> ask_following(Transfers& transfers, HttpRequest& request, const Url& url, bool of_store,
                                const std::stop_token& stop) {
  std::string scheme = url.scheme;
  if (const Permits* permits = transfers.permits(); permits != nullptr && !of_store) {
    BOOST_OUTCOME_TRYV(permits->check_address(url.address, url.shown));
  }
  BOOST_OUTCOME_TRY(reply, ask_once(transfers, request, url.shown, stop));
  if (turn_to_other_region(request, reply)) {
    BOOST_OUTCOME_TRY(again, ask_once(transfers, request, url.shown, stop));
    reply = std::move(again);
  }
  for (int redirects = 0; is_redirect(reply.status); ++redirects) {
    BOOST_OUTCOME_TRY(next, redirected(transfers, reply, request, scheme, redirects, url.shown));
    scheme = next.scheme;
    request.address = next.address;
    BOOST_OUTCOME_TRY(again, ask_once(transfers, request, url.shown, stop));
    reply = std::move(again);
  }
  return std::move(reply);
}

HttpRequest request_of(const Url& url, Asking asking, std::size_t bytes_max) {
  return {.address = url.address,
          .range = {},
          .method = "GET",
          .body = {},
          .headers = std::move(asking.headers),
          .signing = std::move(asking.signing),
          .region = std::move(asking.region),
          .bytes_max = bytes_max};
}

}  // namespace

Result<OpenedObject> open_http(const Url& url, Asking asking, std::shared_ptr<Transfers> transfers,
                               std::size_t begin_bytes, std::stop_token stop) {
  const ByteRange begin{0, begin_bytes};
  const bool of_store = asking.of_store;
  HttpRequest request = request_of(url, std::move(asking), begin_bytes);
  request.range = range_text(begin);
  BOOST_OUTCOME_TRY(reply, ask_following(*transfers, request, url, of_store, stop));
  BOOST_OUTCOME_TRY(got, checked_range(reply, begin, url.shown));
  if (!got.size)
    return error(Errc::bad_input, url.shown +
                                      ": the server does not tell how long the object is; download the file, and read "
                                      "that");
  if (*got.size > std::uint64_t{INT64_MAX} || got.end != std::min<std::uint64_t>(begin_bytes, *got.size))
    return error(Errc::bad_input, url.shown + ": the server says that the object has " + std::to_string(*got.size) +
                                      " bytes, and sent the first " + std::to_string(got.end) + " of " +
                                      std::to_string(begin_bytes) + " that were asked for");
  VersionMarks version{header(reply, "etag"), header(reply, "last-modified"), *got.size};
  return OpenedObject{std::make_unique<HttpObject>(url.shown, std::move(request), std::move(version),
                                                   std::move(transfers), std::move(stop)),
                      std::move(reply.body)};
}

Result<std::vector<std::byte>> get_http(const Url& url, Asking asking, Transfers& transfers, std::size_t bytes_max,
                                        const std::stop_token& stop) {
  const bool of_store = asking.of_store;
  HttpRequest request = request_of(url, std::move(asking), bytes_max);
  BOOST_OUTCOME_TRY(reply, ask_following(transfers, request, url, of_store, stop));
  if (reply.status != 200) {
    if (auto refused = refusal(reply, url.shown)) return std::move(*refused);
  }
  if (!reply.failure.empty()) return error(Errc::io, url.shown + ": " + reply.failure);
  return std::move(reply.body);
}

Result<bool> http_exists(const Url& url, Asking asking, Transfers& transfers, const std::stop_token& stop) {
  const bool of_store = asking.of_store;
  HttpRequest request = request_of(url, std::move(asking), 1);
  request.range = "0-0";
  BOOST_OUTCOME_TRY(reply, ask_following(transfers, request, url, of_store, stop));
  if (reply.status == 403 || reply.status == 404 || reply.status == 410) return false;
  if (reply.status == 200 || reply.status == 206 || reply.status == 416) return true;
  return *refusal(reply, url.shown);
}

}  // namespace tessera::remote
