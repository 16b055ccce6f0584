// Objects of S3 and of servers that speak its protocol, as s3://bucket/folder/file.laz. Source: Amazon S3 API
// Reference, "Virtual hosting of buckets"; AWS SDKs and Tools Reference Guide, "Shared config and credentials files".
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "src/base/result.h"
#include "src/input/remote/http_object.h"
#include "src/input/remote/transfers.h"
#include "src/input/remote/url.h"

namespace tessera::remote {

struct S3Options {
  std::string endpoint = {};    // "https://host[:port]" of a server other than Amazon's; empty: see below
  std::string profile = {};     // in ~/.aws; empty: AWS_PROFILE, else "default"
  bool anonymous = false;       // requests are not signed
  bool requester_pays = false;  // who asks agrees to pay for the transfer
};

// Who asks, and where.
struct S3Access {
  std::string endpoint;                    // empty: Amazon's server for the region
  std::string region;                      // "us-east-1" if nothing says another
  std::shared_ptr<const Signing> signing;  // null: anonymous
  bool requester_pays = false;

  Asking asking() const;  // for requests to that server
};

// Whether a name begins with s3://.
bool is_s3(const std::string& name);

// Finds the credentials as other programs do: AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_SESSION_TOKEN; else
// those of the profile in ~/.aws/credentials or ~/.aws/config (or in the files that AWS_SHARED_CREDENTIALS_FILE and
// AWS_CONFIG_FILE name). The region: AWS_REGION, AWS_DEFAULT_REGION, else that of the profile. The endpoint: the
// option, AWS_ENDPOINT_URL_S3, AWS_ENDPOINT_URL, else that of the profile. `variable` returns null for a variable that
// is not set. Error usage when there are no credentials and `anonymous` is false; io when a file cannot be read.
Result<S3Access> find_s3_access(const S3Options& options, const std::function<const char*(const char*)>& variable);

// A text as a value behind '?' in an address, as it is signed.
std::string as_parameter(const std::string& text);

// The address of an object. Error usage for a name without bucket or key.
Result<Url> s3_address(const std::string& name, const S3Access& access);

}  // namespace tessera::remote
