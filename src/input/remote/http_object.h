// An object behind HTTP: ranges by the header Range, one version by the headers ETag and If-Match.
#pragma once

#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/remote/range_reader.h"
#include "src/input/remote/transfers.h"
#include "src/input/remote/url.h"

namespace tessera::remote {

// How an object is asked for, beyond its address.
struct Asking {
  std::vector<std::string> headers = {};
  std::shared_ptr<const Signing> signing = {};
  std::string region = {};  // of the signature
  // The address was made of a name s3://, which was checked. Other addresses are checked before they are asked.
  bool of_store = false;
};

// An object, and the bytes that came with the first answer.
struct OpenedObject {
  std::unique_ptr<RangeReader> object;
  std::vector<std::byte> begin;
};

// Asks for the first `begin_bytes` bytes. Follows up to five redirects, never from https to http, and none with headers
// or a signature, which are for one server only. When the answer names another region, asks again for that. Errors:
// those of RangeReader::read(); bad_input for an empty object, and when the server does not tell the length or does not
// give ranges.
Result<OpenedObject> open_http(const Url& url, Asking asking, std::shared_ptr<Transfers> transfers,
                               std::size_t begin_bytes, std::stop_token stop);

// The whole of a small object: a listing, a list. Redirects as open_http(). Errors: those of RangeReader::read();
// bad_input for more than `bytes_max` bytes.
Result<std::vector<std::byte>> get_http(const Url& url, Asking asking, Transfers& transfers, std::size_t bytes_max,
                                        const std::stop_token& stop);

// Whether there is an object that may be read. Errors: those of RangeReader::read().
Result<bool> http_exists(const Url& url, Asking asking, Transfers& transfers, const std::stop_token& stop);

}  // namespace tessera::remote
