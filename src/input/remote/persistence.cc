#include "src/input/remote/persistence.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <utility>

#include "src/base/printable.h"

namespace tessera::remote {
namespace {

constexpr std::chrono::milliseconds first_wait{200};
constexpr std::chrono::seconds asked_wait_max{20};

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

// What a server says becomes part of an address, so it may only be what regions are.
bool is_region(std::string_view name) {
  return !name.empty() && name.size() < 40 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
}

}  // namespace

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

std::string code_of_store(const HttpReply& reply) {
  const std::string_view body(reinterpret_cast<const char*>(reply.body.data()), reply.body.size());
  const auto begin = body.find("<Code>"), end = body.find("</Code>");
  if (begin == std::string_view::npos || end == std::string_view::npos || end < begin || end - begin > 64) return "";
  return printable(std::string(body.substr(begin + 6, end - begin - 6)));
}

std::string sentence_of_status(const HttpReply& reply, bool write) {
  const std::string code = code_of_store(reply);
  const std::string status =
      "the server answers with status " + std::to_string(reply.status) + (code.empty() ? "" : " (" + code + ")");
  switch (reply.status) {
    case 401:
      return status + ": it wants to know who asks, and a name and password cannot be given";
    case 403:
      if (code == "QuotaExceeded") return status + ": the store is full";
      return status + ": it does not allow this object to be " + (write ? "written" : "read");
    case 404:
    case 410:
      return status + ": there is no such " + (code == "NoSuchBucket" ? "bucket" : "object");
    case 408:
    case 429:
    case 500:
    case 502:
    case 503:
    case 504:
      return status + ", also after " + std::to_string(tries_max) + " tries: it is overloaded or out of order";
    case 507:
      return status + ": the store is full";
    default:
      return status + (write ? ", so the object is not written" : ", which does not give the object");
  }
}

bool turn_to_other_region(HttpRequest& request, const HttpReply& reply) {
  const std::string& other = header(reply, "x-amz-bucket-region");
  if (request.region.empty() || reply.status < 300 || !is_region(other) || other == request.region) return false;
  const auto old = request.address.find("s3." + request.region + ".amazonaws.com/");
  if (old != std::string::npos) request.address.replace(old + 3, request.region.size(), other);
  request.region = other;
  return true;
}

}  // namespace tessera::remote
