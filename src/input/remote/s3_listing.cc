#include "src/input/remote/s3_listing.h"

#include <expat.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <utility>

#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/input/format.h"
#include "src/input/remote/curl_library.h"
#include "src/input/remote/http_object.h"

namespace tessera::remote {
namespace {

constexpr std::size_t page_of_listing_bytes_max = std::size_t{16} << 20;  // of a thousand keys of 1024 bytes
constexpr std::size_t listed_files_max = 1'000'000;

// Takes what is needed of the elements of a page.
class PageTaker {
 public:
  PageTaker(const CurlLibrary& curl, S3Page& page) : curl_(curl), page_(page) {}
  void begin(std::string_view) {
    text_.clear();
    ++depth_;
  }
  void text(std::string_view more) { text_ += more; }
  void end(std::string_view name) {
    --depth_;
    if (name == "Key" && depth_ == 2) page_.keys.push_back(decoded());
    if (name == "NextContinuationToken" && depth_ == 1) page_.next = text_;
    if (name == "IsTruncated" && depth_ == 1) truncated_ = text_ == "true";
    if (name == "CommonPrefixes") page_.folders = true;
    if (depth_ == 0) whole_ = name == "ListBucketResult";
    text_.clear();
  }
  void refuse() { refused_ = true; }
  bool whole() const { return whole_ && !refused_; }
  bool truncated() const { return truncated_; }

 private:
  // Keys come as in addresses (encoding-type=url), because XML has no way to write some characters.
  std::string decoded() const {
    int length = 0;
    const std::unique_ptr<char, decltype(curl_.free)> plain(
        curl_.easy_unescape(nullptr, text_.data(), static_cast<int>(text_.size()), &length), curl_.free);
    return plain ? std::string(plain.get(), static_cast<std::size_t>(length)) : text_;
  }

  const CurlLibrary& curl_;
  S3Page& page_;
  std::string text_;
  int depth_ = 0;
  bool whole_ = false, truncated_ = false, refused_ = false;
};

}  // namespace

Result<S3Page> parse_s3_page(std::span<const std::byte> xml) {
  BOOST_OUTCOME_TRY(curl, curl_library());
  S3Page page;
  PageTaker taker(*curl, page);
  const std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser(XML_ParserCreate(nullptr),
                                                                                             &XML_ParserFree);
  if (!parser) return error(Errc::memory, "no memory for reading XML");
  XML_SetUserData(parser.get(), &taker);
  XML_SetElementHandler(
      parser.get(), [](void* to, const char* name, const char**) { static_cast<PageTaker*>(to)->begin(name); },
      [](void* to, const char* name) { static_cast<PageTaker*>(to)->end(name); });
  XML_SetCharacterDataHandler(parser.get(), [](void* to, const char* text, int length) {
    static_cast<PageTaker*>(to)->text({text, static_cast<std::size_t>(length)});
  });
  // A document type could define entities that grow without bound. A listing has none.
  XML_SetStartDoctypeDeclHandler(parser.get(), [](void* to, const char*, const char*, const char*, int) {
    static_cast<PageTaker*>(to)->refuse();
  });
  const auto parsed =
      XML_Parse(parser.get(), reinterpret_cast<const char*>(xml.data()), static_cast<int>(xml.size()), XML_TRUE);
  if (parsed != XML_STATUS_OK || !taker.whole()) return error(Errc::bad_input, "its answer is no listing of a bucket");
  if (taker.truncated() && page.next.empty())
    return error(Errc::bad_input, "its listing goes on, but does not say where");
  if (!taker.truncated()) page.next.clear();
  return page;
}

Result<std::vector<std::string>> list_s3(const std::string& name, bool recursive, const S3Access& access,
                                         Transfers& transfers, const std::stop_token& stop) {
  const auto slash = name.find('/', 5);
  const std::string bucket = name.substr(0, slash) + "/", folder = slash == name.npos ? "" : name.substr(slash + 1);
  BOOST_OUTCOME_TRY(url, s3_address(bucket, access));
  std::vector<std::string> names;
  bool folders = false;
  S3Page page;
  do {
    // Sorted by their names, because a signature is of the sorted parameters.
    std::string parameters = page.next.empty() ? "" : "continuation-token=" + as_parameter(page.next) + "&";
    if (!recursive) parameters += "delimiter=%2F&";
    parameters += "encoding-type=url&list-type=2&prefix=" + as_parameter(folder);
    Url page_url = url;
    page_url.address += "?" + parameters;
    page_url.shown = name;
    BOOST_OUTCOME_TRY(answer, get_http(page_url, access.asking(), transfers, page_of_listing_bytes_max, stop));
    auto parsed = parse_s3_page(answer);
    if (parsed.has_error()) return error(parsed.error().code, printable(name) + ": " + parsed.error().where);
    page = std::move(parsed).value();
    folders = folders || page.folders;
    for (const auto& key : page.keys)
      if (has_point_file_name(key)) names.push_back(bucket + key);
    if (names.size() > listed_files_max)
      return error(Errc::usage, printable(name) + ": holds more than a million files");
  } while (!page.next.empty());
  if (names.empty())
    return error(Errc::io, printable(name) + ": holds no point files (" + point_file_endings() +
                               ", and these with .gz or .zst)" +
                               (folders ? "; " + option("recursive", "true") + " looks into its folders, too" : ""));
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace tessera::remote
