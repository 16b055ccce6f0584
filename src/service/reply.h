// What the service answers: a value or a file, or a problem.
#pragma once

#include <cstdint>
#include <string>

#include "service.pb.h"
#include "src/base/result.h"

namespace tessera::service {

// An answer, or a problem with its HTTP status.
template <class T>
using Reply = boost::outcome_v2::basic_result<T, proto::Problem, boost::outcome_v2::policy::terminate>;

// A file to be sent. It is open for reading, so that no other file can take its place.
struct ServedFile {
  int descriptor = -1;  // the receiver closes it
  std::uint64_t bytes = 0;
  std::string type;  // media type
  std::string etag;  // strong, quoted, from the checksum in the manifest; empty for a file that still grows
};

}  // namespace tessera::service
