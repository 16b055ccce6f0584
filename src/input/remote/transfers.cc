#include "src/input/remote/transfers.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <span>
#include <string_view>
#include <thread>
#include <utility>

#include "src/base/printable.h"
#include "src/input/remote/curl_library.h"
#include "src/input/remote/permits.h"
#include "src/input/remote/sha256.h"
#include "src/input/remote/url.h"

namespace tessera::remote {
namespace {

// The answers of one caller, who waits until none is left.
struct Call {
  std::size_t left = 0;
  bool given_up = false;
};

struct Transfer {
  Call* call = nullptr;
  const HttpRequest* request = nullptr;
  HttpReply* reply = nullptr;
};

// An answer while it arrives.
struct Arriving {
  const CurlLibrary& curl;
  Transfer transfer = {};
  CURL* handle = nullptr;
  curl_slist* headers = nullptr;
  std::size_t header_bytes = 0;
  bool too_long = false;
  std::string host = {};     // of the request, where addresses are checked
  std::string refused = {};  // the number of an address to which no connection may be made
  std::array<char, CURL_ERROR_SIZE> reason{};
};

constexpr std::size_t header_bytes_max = std::size_t{64} << 10;
constexpr std::size_t refusal_bytes_max = std::size_t{4} << 10;  // enough for the error of an object store

// libcurl is C, so no exception may leave these functions.
std::size_t take_header(char* text, std::size_t, std::size_t bytes, void* to) try {
  auto& arriving = *static_cast<Arriving*>(to);
  if ((arriving.header_bytes += bytes) > header_bytes_max) {
    arriving.too_long = true;
    return 0;
  }
  const std::string_view line(text, bytes);
  if (line.starts_with("HTTP/")) arriving.transfer.reply->headers.clear();  // after 100 Continue the real answer begins
  const auto colon = line.find(':');
  if (colon == std::string_view::npos) return bytes;
  std::string name(line.substr(0, colon));
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto begin = line.find_first_not_of(" \t", colon + 1);
  const auto end = line.find_last_not_of(" \t\r\n");
  arriving.transfer.reply->headers[name] =
      begin == std::string_view::npos || begin > end ? "" : std::string(line.substr(begin, end + 1 - begin));
  return bytes;
} catch (const std::bad_alloc&) {
  return 0;
}

// run() has made the body's room, so nothing is allocated here.
std::size_t take_body(char* bytes, std::size_t, std::size_t count, void* to) {
  auto& arriving = *static_cast<Arriving*>(to);
  auto& body = arriving.transfer.reply->body;
  long status = 0;
  arriving.curl.easy_getinfo(arriving.handle, CURLINFO_RESPONSE_CODE, &status);
  const auto from = std::as_bytes(std::span(bytes, count));
  if (status == 200 && !arriving.transfer.request->range.empty()) return 0;  // the whole object, which may be large
  if (status != 206 && status != 200) {
    const auto room = std::min(body.capacity(), refusal_bytes_max) - body.size();
    body.insert(body.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(std::min(room, count)));
    return room == 0 ? 0 : count;
  }
  if (count > arriving.transfer.request->bytes_max - body.size()) {
    arriving.too_long = true;
    return 0;
  }
  body.insert(body.end(), from.begin(), from.end());
  return count;
}

// Makes the socket of a connection, unless its address leads inward.
curl_socket_t open_socket(void* to, curlsocktype, curl_sockaddr* address) try {
  auto& arriving = *static_cast<Arriving*>(to);
  if (leads_inward(address->addr) && !is_number_of(arriving.host, address->addr)) {
    arriving.refused = address_number(address->addr);
    return CURL_SOCKET_BAD;
  }
  return ::socket(address->family, address->socktype | SOCK_CLOEXEC, address->protocol);
} catch (const std::bad_alloc&) {
  return CURL_SOCKET_BAD;
}

// Whether the next try may end otherwise.
bool is_passing(CURLcode code) {
  switch (code) {
    case CURLE_COULDNT_CONNECT:
    case CURLE_GOT_NOTHING:
    case CURLE_HTTP2:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_PARTIAL_FILE:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_ERROR:
    case CURLE_SSL_CONNECT_ERROR:
      return true;
    default:
      return false;
  }
}

// SHA-256 of what a request sends, or the word for a body without a signature of its own.
std::string digest_of_body(const HttpRequest& request) {
  const std::vector<std::byte> nothing;
  return sha256(request.body ? *request.body : nothing).value_or("UNSIGNED-PAYLOAD");
}

// The server compares what arrives with its digest, which is a part of the signature.
void sign(const CurlLibrary& curl, CURL* handle, const HttpRequest& request) {
  curl.easy_setopt(handle, CURLOPT_AWS_SIGV4, ("aws:amz:" + request.region + ":s3").c_str());
  curl.easy_setopt(handle, CURLOPT_USERNAME, request.signing->key.c_str());
  curl.easy_setopt(handle, CURLOPT_PASSWORD, request.signing->secret.c_str());
}

bool sends(const HttpRequest& request) { return request.method == "PUT" || request.method == "POST"; }

curl_slist* headers_of(const CurlLibrary& curl, const HttpRequest& request) {
  curl_slist* list = nullptr;
  for (const auto& header : request.headers) list = curl.slist_append(list, header.c_str());
  if (sends(request)) list = curl.slist_append(list, "Content-Type: application/octet-stream");
  if (!request.signing) return list;
  list = curl.slist_append(list, ("x-amz-content-sha256: " + digest_of_body(request)).c_str());
  const std::string& token = request.signing->token;
  if (!token.empty()) list = curl.slist_append(list, ("x-amz-security-token: " + token).c_str());
  return list;
}

// What is asked, and what is sent with it.
void set_method(const CurlLibrary& curl, CURL* handle, const HttpRequest& request) {
  if (sends(request)) {
    const bool empty = !request.body || request.body->empty();
    curl.easy_setopt(handle, CURLOPT_POSTFIELDSIZE_LARGE,
                     empty ? curl_off_t{0} : static_cast<curl_off_t>(request.body->size()));
    curl.easy_setopt(handle, CURLOPT_POSTFIELDS, empty ? "" : static_cast<const void*>(request.body->data()));
  }
  if (request.method != "GET") curl.easy_setopt(handle, CURLOPT_CUSTOMREQUEST, request.method.c_str());
}

}  // namespace

struct Transfers::Impl {
  Impl(const CurlLibrary& library, const Patience& how_long, std::string trusted, std::shared_ptr<const Permits> given)
      : curl(library), patience(how_long), ca_file(std::move(trusted)), permits(std::move(given)) {}

  void begin(const Transfer& transfer);
  void end(std::size_t index, CURLcode code);
  void finished(const Transfer& transfer);
  void loop();
  void start_waiting();
  void drop_given_up();
  void finish_arrived();

  const CurlLibrary& curl;
  const pid_t process = ::getpid();
  Patience patience;
  std::string ca_file;
  std::shared_ptr<const Permits> permits;
  CURLM* multi = nullptr;
  std::mutex mutex;
  std::condition_variable_any done;
  std::deque<Transfer> waiting;                      // guarded by mutex, as all Call objects are
  bool closing = false;                              // guarded by mutex
  std::vector<std::unique_ptr<Arriving>> under_way;  // of the thread alone
  std::jthread thread;                               // last: it uses all the others
};

void Transfers::Impl::begin(const Transfer& transfer) {
  auto arriving = std::make_unique<Arriving>(Arriving{.curl = curl});
  arriving->transfer = transfer;
  CURL* handle = arriving->handle = curl.easy_init();
  if (handle == nullptr) {
    transfer.reply->failure = "no memory is left to ask for it";
    finished(transfer);
    return;
  }
  const HttpRequest& request = *transfer.request;
  arriving->headers = headers_of(curl, request);
  curl.easy_setopt(handle, CURLOPT_URL, request.address.c_str());
  curl.easy_setopt(handle, CURLOPT_PROTOCOLS_STR, "http,https");
  curl.easy_setopt(handle, CURLOPT_FOLLOWLOCATION, 0L);
  curl.easy_setopt(handle, CURLOPT_NOSIGNAL, 1L);
  // One connection for each request under way: a single one is as fast as one stream of TCP.
  curl.easy_setopt(handle, CURLOPT_HTTP_VERSION, long{CURL_HTTP_VERSION_1_1});
  curl.easy_setopt(handle, CURLOPT_HTTP09_ALLOWED, 0L);
  curl.easy_setopt(handle, CURLOPT_USERAGENT, "tessera");
  if (!request.range.empty()) curl.easy_setopt(handle, CURLOPT_RANGE, request.range.c_str());
  if (request.signing) sign(curl, handle, request);
  if (!ca_file.empty()) curl.easy_setopt(handle, CURLOPT_CAINFO, ca_file.c_str());
  if (permits) {
    const auto url = parse_url(request.address);
    if (url.has_value()) arriving->host = url.value().host;
    curl.easy_setopt(handle, CURLOPT_PROXY, "");  // a proxy would connect to what this process must not
    curl.easy_setopt(handle, CURLOPT_OPENSOCKETFUNCTION, open_socket);
    curl.easy_setopt(handle, CURLOPT_OPENSOCKETDATA, arriving.get());
  }
  set_method(curl, handle, request);
  curl.easy_setopt(handle, CURLOPT_HTTPHEADER, arriving->headers);
  curl.easy_setopt(handle, CURLOPT_CONNECTTIMEOUT_MS, patience.connect_ms);
  curl.easy_setopt(handle, CURLOPT_LOW_SPEED_LIMIT, patience.slow_bytes);
  curl.easy_setopt(handle, CURLOPT_LOW_SPEED_TIME, sends(request) ? patience.slow_write_s : patience.slow_s);
  curl.easy_setopt(handle, CURLOPT_TIMEOUT, sends(request) ? patience.whole_write_s : patience.whole_s);
  curl.easy_setopt(handle, CURLOPT_HEADERFUNCTION, take_header);
  curl.easy_setopt(handle, CURLOPT_HEADERDATA, arriving.get());
  curl.easy_setopt(handle, CURLOPT_WRITEFUNCTION, take_body);
  curl.easy_setopt(handle, CURLOPT_WRITEDATA, arriving.get());
  curl.easy_setopt(handle, CURLOPT_ERRORBUFFER, arriving->reason.data());
  curl.easy_setopt(handle, CURLOPT_PRIVATE, arriving.get());
  curl.multi_add_handle(multi, handle);
  under_way.push_back(std::move(arriving));
}

void Transfers::Impl::finished(const Transfer& transfer) {
  {
    const std::lock_guard lock(mutex);
    --transfer.call->left;
  }
  done.notify_all();
}

// Takes a transfer out, and tells its caller.
void Transfers::Impl::end(std::size_t index, CURLcode code) {
  Arriving& arriving = *under_way[index];
  HttpReply& reply = *arriving.transfer.reply;
  long status = 0;
  curl.easy_getinfo(arriving.handle, CURLINFO_RESPONSE_CODE, &status);
  reply.status = static_cast<int>(status);
  const char* redirect = nullptr;
  curl.easy_getinfo(arriving.handle, CURLINFO_REDIRECT_URL, &redirect);
  if (redirect != nullptr) reply.redirect = redirect;
  const bool cut_short = code == CURLE_WRITE_ERROR && !arriving.too_long;  // by take_body(), which has seen enough
  if (arriving.too_long) {
    reply.failure = "its answer is longer than what was asked for";
  } else if (code != CURLE_OK && !arriving.refused.empty()) {
    reply.failure = "its name leads to " + arriving.refused +
                    ", an address of this machine or of what serves machines about themselves, to which this service "
                    "connects only if a prefix names the number itself";
  } else if (code != CURLE_OK && !cut_short) {
    reply.failure = printable(arriving.reason[0] != 0 ? arriving.reason.data() : curl.easy_strerror(code));
    reply.passing = is_passing(code);
  }
  curl.multi_remove_handle(multi, arriving.handle);
  curl.easy_cleanup(arriving.handle);
  curl.slist_free_all(arriving.headers);
  finished(arriving.transfer);
  under_way.erase(under_way.begin() + static_cast<std::ptrdiff_t>(index));
}

void Transfers::Impl::start_waiting() {
  while (under_way.size() < in_flight_max) {
    Transfer next;
    {
      const std::lock_guard lock(mutex);
      if (waiting.empty()) return;
      next = waiting.front();
      waiting.pop_front();
    }
    begin(next);
  }
}

// Ends the transfers of callers that were interrupted.
void Transfers::Impl::drop_given_up() {
  for (std::size_t i = under_way.size(); i-- > 0;) {
    bool given_up = false;
    {
      const std::lock_guard lock(mutex);
      given_up = under_way[i]->transfer.call->given_up;
    }
    if (given_up) end(i, CURLE_ABORTED_BY_CALLBACK);
  }
}

void Transfers::Impl::finish_arrived() {
  int more = 0;
  while (const CURLMsg* message = curl.multi_info_read(multi, &more)) {
    if (message->msg != CURLMSG_DONE) continue;
    const auto found = std::find_if(under_way.begin(), under_way.end(),
                                    [&](const auto& each) { return each->handle == message->easy_handle; });
    if (found != under_way.end()) end(static_cast<std::size_t>(found - under_way.begin()), message->data.result);
  }
}

void Transfers::Impl::loop() {
  while (true) {
    {
      const std::lock_guard lock(mutex);
      if (closing) return;
    }
    start_waiting();
    drop_given_up();
    int running = 0;
    curl.multi_perform(multi, &running);
    finish_arrived();
    const auto has_waiting = [&] {
      const std::lock_guard lock(mutex);
      return !waiting.empty() && under_way.size() < in_flight_max;
    };
    constexpr int second_ms = 1000;
    if (!has_waiting()) curl.multi_poll(multi, nullptr, 0, second_ms, nullptr);
  }
}

Transfers::Transfers(const Patience& patience, std::string ca_file, std::shared_ptr<const Permits> permits)
    : impl_(std::make_unique<Impl>(*curl_library().value(), patience, std::move(ca_file), std::move(permits))) {
  impl_->multi = impl_->curl.multi_init();
  if (impl_->multi == nullptr) throw std::bad_alloc();
  impl_->curl.multi_setopt(impl_->multi, CURLMOPT_MAXCONNECTS, long{in_flight_max});
  impl_->thread = std::jthread([impl = impl_.get()] { impl->loop(); });
}

Transfers::~Transfers() {
  if (impl_->process != ::getpid()) {  // the thread is the parent's
    static_cast<void>(impl_.release());
    return;
  }
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->closing = true;
  }
  impl_->curl.multi_wakeup(impl_->multi);
  impl_->thread.join();
  impl_->curl.multi_cleanup(impl_->multi);
}

const Permits* Transfers::permits() const { return impl_->permits.get(); }

Result<std::vector<HttpReply>> Transfers::run(const std::vector<HttpRequest>& requests, const std::stop_token& stop) {
  std::vector<HttpReply> replies(requests.size());
  for (std::size_t i = 0; i < requests.size(); ++i)
    replies[i].body.reserve(std::max(requests[i].bytes_max, refusal_bytes_max));
  Call call{.left = requests.size()};
  std::unique_lock lock(impl_->mutex);
  for (std::size_t i = 0; i < requests.size(); ++i) impl_->waiting.push_back({&call, &requests[i], &replies[i]});
  lock.unlock();
  impl_->curl.multi_wakeup(impl_->multi);
  lock.lock();
  if (impl_->done.wait(lock, stop, [&] { return call.left == 0; })) return replies;
  call.given_up = true;
  auto& waiting = impl_->waiting;
  for (auto it = waiting.begin(); it != waiting.end();) {
    if (it->call != &call) {
      ++it;
      continue;
    }
    it = waiting.erase(it);
    --call.left;
  }
  impl_->curl.multi_wakeup(impl_->multi);
  impl_->done.wait(lock, [&] { return call.left == 0; });
  return error(Errc::interrupted, "interrupted while objects were read");
}

}  // namespace tessera::remote
