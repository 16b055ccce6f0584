// What is in a bucket. Source: Amazon S3 API Reference, "ListObjectsV2".
#pragma once

#include <cstddef>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"
#include "src/input/remote/s3.h"
#include "src/input/remote/transfers.h"

namespace tessera::remote {

// A page of a listing.
struct S3Page {
  std::vector<std::string> keys;
  std::string next;      // asks for the next page; empty on the last one
  bool folders = false;  // there are keys below, which a listing without subfolders leaves out
};

// Parses the XML of a page. The error is what is wrong with it, without a name.
Result<S3Page> parse_s3_page(std::span<const std::byte> xml);

// The names (s3://...) of the point files in a folder of a bucket, sorted by bytes. `name` is s3://bucket/folder/ or
// s3://bucket. With `recursive` also those in folders below. Errors: usage when there are none, or more than a million;
// those of reading an object.
Result<std::vector<std::string>> list_s3(const std::string& name, bool recursive, const S3Access& access,
                                         Transfers& transfers, const std::stop_token& stop);

}  // namespace tessera::remote
