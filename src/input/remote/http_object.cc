#include "src/input/remote/http_object.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/remote/curl_library.h"
#include "src/input/remote/permits.h"

namespace tessera::remote {
namespace {

constexpr int tries_max = 5, redirects_max = 5;
constexpr std::chrono::milliseconds first_wait{200};
constexpr std::chrono::seconds asked_wait_max{20};

const std::string& header(const HttpReply& reply, const char* name) {
  static const std::string none;
  const auto found = reply.headers.find(name);
  return found == reply.headers.end() ? none : found->second;
}

std::optional<std::uint64_t> number_of(std::string_view text) {
  std::uint64_t number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (code != std::errc() || end != text.data() + text.size() || text.empty()) return {};
  return number;
}

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

// Waits before another try. Returns false after `stop`.
bool wait_for(std::chrono::milliseconds time, const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  never.wait_for(lock, stop, time, [] { return false; });
  return !stop.stop_requested();
}

bool may_pass(const HttpReply& reply) {
  const int s = reply.status;
  return reply.passing || s == 408 || s == 429 || s == 500 || s == 502 || s == 503 || s == 504;
}

// Sends requests until each has an answer that another try would not better, with growing waits between the tries.
Result<std::vector<HttpReply>> persistently(Transfers& transfers, const std::vector<HttpRequest>& requests,
                                            const std::string& name, const std::stop_token& stop) {
  std::vector<HttpReply> replies(requests.size());
  std::vector<std::size_t> open(requests.size());
  std::iota(open.begin(), open.end(), std::size_t{0});
  auto wait = first_wait;
  for (int tried = 1;; ++tried) {
    std::vector<HttpRequest> again;
    for (const std::size_t i : open) again.push_back(requests[i]);
    BOOST_OUTCOME_TRY(got, transfers.run(again, stop));
    std::vector<std::size_t> still_open;
    auto asked_wait = std::chrono::milliseconds{0};
    for (std::size_t k = 0; k < open.size(); ++k) {
      HttpReply& reply = replies[open[k]] = std::move(got[k]);
      if (!may_pass(reply)) continue;
      still_open.push_back(open[k]);
      if (const auto seconds = number_of(header(reply, "retry-after")))
        asked_wait = std::max<std::chrono::milliseconds>(
            asked_wait, std::min(asked_wait_max, std::chrono::seconds(std::min<std::uint64_t>(*seconds, 3600))));
    }
    if (still_open.empty() || tried == tries_max) return replies;
    if (!wait_for(std::max(wait, asked_wait), stop))
      return error(Errc::interrupted, "interrupted while " + name + " was read");
    open = std::move(still_open);
    wait *= 2;
  }
}

// The reason that a store of objects gives: "NoSuchKey".
std::string code_of_store(const HttpReply& reply) {
  const std::string_view body(reinterpret_cast<const char*>(reply.body.data()), reply.body.size());
  const auto begin = body.find("<Code>"), end = body.find("</Code>");
  if (begin == std::string_view::npos || end == std::string_view::npos || end < begin || end - begin > 64) return "";
  return printable(std::string(body.substr(begin + 6, end - begin - 6)));
}

std::string sentence_of_status(const HttpReply& reply) {
  const std::string code = code_of_store(reply);
  const std::string status =
      "the server answers with status " + std::to_string(reply.status) + (code.empty() ? "" : " (" + code + ")");
  switch (reply.status) {
    case 401:
      return status + ": it wants to know who asks, and a name and password cannot be given";
    case 403:
      return status + ": it does not allow this object to be read";
    case 404:
    case 410:
      return status + ": there is no such object";
    case 408:
    case 429:
    case 500:
    case 502:
    case 503:
    case 504:
      return status + ", also after " + std::to_string(tries_max) + " tries: it is overloaded or out of order";
    default:
      return status + ", which does not give the object";
  }
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

// What a server says becomes part of an address, so it may only be what regions are.
bool is_region(std::string_view name) {
  return !name.empty() && name.size() < 40 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
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
  const std::string& other_region = header(reply, "x-amz-bucket-region");
  if (!request.region.empty() && reply.status >= 300 && is_region(other_region) && other_region != request.region) {
    const auto old = request.address.find("s3." + request.region + ".amazonaws.com/");
    if (old != std::string::npos) request.address.replace(old + 3, request.region.size(), other_region);
    request.region = other_region;
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

}  // namespace tessera::remote
