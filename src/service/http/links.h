// The links in answers: relative to the answer's own address, or absolute below a public address.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "service.pb.h"
#include "src/service/http/message.h"

namespace tessera::service::http {

inline constexpr std::string_view result_not_ready =
    "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/result-not-ready";

class Links {
 public:
  // `public_url` is "https://host/prefix", or empty.
  explicit Links(std::string public_url);

  // The address of `path` ("/v1/...") in an answer to `request`.
  std::string to(const Request& request, std::string_view path) const;
  proto::Link link(const Request& request, std::string_view path, std::string rel, std::string type,
                   std::string title = {}) const;

  void add(const Request& request, proto::StatusInfo& job) const;
  void add(const Request& request, proto::TriangulationInfo& triangulation) const;

 private:
  std::string public_url_;
};

std::string job_path(std::string_view id);
std::string triangulation_path(std::string_view name);
// `path` may contain slashes.
std::string file_path(std::string_view triangulation, std::string_view path);

}  // namespace tessera::service::http
