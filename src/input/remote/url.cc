#include "src/input/remote/url.h"

#include <algorithm>
#include <cctype>
#include <memory>
#include <utility>

#include "src/base/printable.h"
#include "src/input/remote/curl_library.h"

namespace tessera::remote {
namespace {

using Handle = std::unique_ptr<CURLU, decltype(CurlLibrary::url_cleanup)>;

std::string part(const CurlLibrary& curl, const Handle& url, CURLUPart which, unsigned flags = 0) {
  char* text = nullptr;
  if (curl.url_get(url.get(), which, &text, flags) != CURLUE_OK) return "";
  std::string copied(text);
  curl.free(text);
  return copied;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

std::string without_secrets(const std::string& text) {
  std::string shown = text.substr(0, text.find_first_of("?#"));
  const auto host = shown.find("://");
  if (host != std::string::npos) {
    const auto slash = shown.find('/', host + 3);
    const auto at = shown.rfind('@', slash);
    if (at != std::string::npos && at > host) shown.erase(host + 3, at + 1 - (host + 3));
  }
  return printable(shown);
}

Result<Url> parse_url(const std::string& text) {
  const std::string shown = without_secrets(text);
  const auto refuse = [&](const std::string& what) { return error(Errc::usage, shown + ": " + what); };
  BOOST_OUTCOME_TRY(library, curl_library());
  const CurlLibrary& curl = *library;
  const Handle url(curl.url(), curl.url_cleanup);
  if (!url) return error(Errc::memory, shown + ": no memory is left to read its address");
  const std::string scheme = lower(text.substr(0, text.find("://")));
  if (scheme != "http" && scheme != "https")
    return refuse("objects are read by https://, http://, s3://, gs:// and az://, not by " + printable(scheme) + "://");
  // A blank in the path is a mistake of people, not of programs: it is sent as %20.
  if (curl.url_set(url.get(), CURLUPART_URL, text.c_str(), CURLU_URLENCODE) != CURLUE_OK)
    return refuse("is no address of an object, as https://host/folder/file.laz is");
  if (!part(curl, url, CURLUPART_USER).empty() || !part(curl, url, CURLUPART_PASSWORD).empty())
    return refuse("its address has a user name or password, which would be kept in the result; leave it out");
  curl.url_set(url.get(), CURLUPART_FRAGMENT, nullptr, 0);
  std::string host = lower(part(curl, url, CURLUPART_HOST));
  if (host.size() > 2 && host.front() == '[') host = host.substr(1, host.size() - 2);
  if (host.empty()) return refuse("names no host");
  return Url{part(curl, url, CURLUPART_URL),
             shown,
             scheme,
             std::move(host),
             part(curl, url, CURLUPART_PORT, CURLU_DEFAULT_PORT),
             part(curl, url, CURLUPART_PATH)};
}

}  // namespace tessera::remote
