#include "src/input/remote/s3.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/base/printable.h"
#include "src/input/remote/curl_library.h"

namespace tessera::remote {
namespace {

using Section = std::map<std::string, std::string>;
using Variable = std::function<const char*(const char*)>;

std::string value_of(const Variable& variable, const char* name) {
  const char* text = variable(name);
  return text == nullptr ? "" : text;
}

std::string_view trimmed(std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t\r") + 1 - begin);
}

// The keys of one section. Lines that begin with a blank belong to nested settings, which are not needed here.
Section section_of(std::string_view text, std::string_view wanted) {
  Section section;
  bool inside = false;
  while (!text.empty()) {
    const auto end = text.find('\n');
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    const auto content = trimmed(line);
    if (content.empty() || content[0] == '#' || content[0] == ';' || line[0] == ' ' || line[0] == '\t') continue;
    if (content[0] == '[') {
      inside = trimmed(content.substr(1, content.find(']') - 1)) == wanted;
      continue;
    }
    const auto equal = content.find('=');
    if (!inside || equal == std::string_view::npos) continue;
    section[std::string(trimmed(content.substr(0, equal)))] = trimmed(content.substr(equal + 1));
  }
  return section;
}

// The text of a file of ~/.aws; nothing when the user has none.
Result<std::string> text_of(const std::string& named, const std::string& home, const char* usual) {
  if (named.empty() && home.empty()) return std::string();
  const std::filesystem::path path =
      named.empty() ? std::filesystem::path(home) / ".aws" / usual : std::filesystem::path(named);
  BOOST_OUTCOME_TRY(bytes, bytes_if_there(path));
  if (!bytes && named.empty()) return std::string();
  constexpr std::uint64_t bytes_max = 1 << 20;
  if (bytes && *bytes > bytes_max)
    return error(Errc::usage, path.string() + ": has " + std::to_string(*bytes) + " bytes, too many for profiles");
  BOOST_OUTCOME_TRY(content, read_whole(path));
  return std::string(as_text(content));
}

// What both files say of a profile; the file of credentials is stronger.
Result<Section> profile_of(const std::string& name, const Variable& variable) {
  const std::string home = value_of(variable, "HOME");
  BOOST_OUTCOME_TRY(config, text_of(value_of(variable, "AWS_CONFIG_FILE"), home, "config"));
  BOOST_OUTCOME_TRY(credentials, text_of(value_of(variable, "AWS_SHARED_CREDENTIALS_FILE"), home, "credentials"));
  Section section = section_of(credentials, name);
  const bool in_credentials = section.contains("aws_access_key_id");
  for (auto& [key, value] : section_of(config, name == "default" ? name : "profile " + name)) {
    // A key of one file must not be joined with the token of another.
    if (!in_credentials || !key.starts_with("aws_")) section.emplace(key, value);
  }
  return section;
}

std::string first_of(std::initializer_list<std::string> texts) {
  for (const auto& text : texts)
    if (!text.empty()) return text;
  return "";
}

// The bytes of a key as a path: all but letters, digits and "-._~/" as %XX, which is how it is signed.
std::string encoded(std::string_view key) {
  constexpr const char* digits = "0123456789ABCDEF";
  std::string path;
  for (const char c : key) {
    const auto byte = static_cast<unsigned char>(c);
    if ((std::isalnum(byte) != 0 && byte < 0x80) || std::string_view("-._~/").find(c) != std::string_view::npos) {
      path += c;
    } else {
      path += '%';
      path += digits[byte >> 4];
      path += digits[byte & 15];
    }
  }
  return path;
}

bool is_bucket(std::string_view name) {
  return name.size() >= 3 && name.size() <= 63 && std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '.' || c == '_';
         });
}

}  // namespace

Asking S3Access::asking() const {
  Asking asking{.headers = {}, .signing = signing, .region = region, .of_store = true};
  if (requester_pays) asking.headers.push_back("x-amz-request-payer: requester");
  return asking;
}

std::string as_parameter(const std::string& text) {
  const auto curl = curl_library();
  if (!curl) return "";  // then no request can be made at all
  const std::unique_ptr<char, decltype(CurlLibrary::free)> made(
      curl.value()->easy_escape(nullptr, text.data(), static_cast<int>(text.size())), curl.value()->free);
  return made ? made.get() : "";
}

bool is_s3(const std::string& name) { return name.starts_with("s3://"); }

Result<S3Access> find_s3_access(const S3Options& options, const Variable& variable) {
  const std::string profile = first_of({options.profile, value_of(variable, "AWS_PROFILE"), "default"});
  BOOST_OUTCOME_TRY(section, profile_of(profile, variable));
  if (!options.profile.empty() && section.empty())
    return error(Errc::usage, option("profile") + ": neither ~/.aws/credentials nor ~/.aws/config has a profile '" +
                                  printable(profile) + "'");
  S3Access access{.endpoint = first_of({options.endpoint, value_of(variable, "AWS_ENDPOINT_URL_S3"),
                                        value_of(variable, "AWS_ENDPOINT_URL"), section["endpoint_url"]}),
                  .region = first_of({value_of(variable, "AWS_REGION"), value_of(variable, "AWS_DEFAULT_REGION"),
                                      section["region"], "us-east-1"}),
                  .signing = {},
                  .requester_pays = options.requester_pays};
  if (options.anonymous) return access;
  Signing signing{value_of(variable, "AWS_ACCESS_KEY_ID"), value_of(variable, "AWS_SECRET_ACCESS_KEY"),
                  value_of(variable, "AWS_SESSION_TOKEN")};
  if (!options.profile.empty() || signing.key.empty() || signing.secret.empty())
    signing = {section["aws_access_key_id"], section["aws_secret_access_key"], section["aws_session_token"]};
  if (signing.key.empty() || signing.secret.empty())
    return error(Errc::usage,
                 "s3://: there are no credentials, neither in AWS_ACCESS_KEY_ID and "
                 "AWS_SECRET_ACCESS_KEY nor in the profile '" +
                     printable(profile) + "' of ~/.aws/credentials; objects that anyone may read need " +
                     option("anonymous", "true"));
  access.signing = std::make_shared<const Signing>(std::move(signing));
  return access;
}

Result<Url> s3_address(const std::string& name, const S3Access& access) {
  const std::string shown = printable(name);
  const std::string place = name.substr(5);
  const auto slash = place.find('/');
  const std::string bucket = place.substr(0, slash), key = slash == std::string::npos ? "" : place.substr(slash + 1);
  if (!is_bucket(bucket))
    return error(Errc::usage, shown +
                                  ": names no bucket, as s3://bucket/folder/file.laz does; a bucket has 3 to 63 "
                                  "small letters, digits, points and dashes");
  // An address has no such parts, so another object would be asked for.
  if (const std::string parts = "/" + key + "/"; parts.find("/../") != parts.npos || parts.find("/./") != parts.npos)
    return error(Errc::usage, shown + ": has a part '.' or '..', which no address has");
  std::string address;
  if (!access.endpoint.empty()) {
    BOOST_OUTCOME_TRY(endpoint, parse_url(access.endpoint));
    address = endpoint.address;
    while (address.ends_with('/')) address.pop_back();
    address += "/" + bucket;
  } else if (bucket.find('.') != std::string::npos) {  // no certificate is for such a name of a host
    address = "https://s3." + access.region + ".amazonaws.com/" + bucket;
  } else {
    address = "https://" + bucket + ".s3." + access.region + ".amazonaws.com";
  }
  BOOST_OUTCOME_TRY(url, parse_url(address + "/" + encoded(key)));
  url.shown = shown;
  return url;
}

}  // namespace tessera::remote
