#include "src/service/http/links.h"

#include <algorithm>
#include <cstddef>

#include "src/base/files/names.h"

namespace tessera::service::http {
namespace {

bool is_terminal(std::string_view state) { return state != "accepted" && state != "running"; }

}  // namespace

std::string job_path(std::string_view id) { return "/v1/jobs/" + encode_segment(id); }
std::string triangulation_path(std::string_view name) { return "/v1/triangulations/" + encode_segment(name); }

std::string file_path(std::string_view triangulation, std::string_view path) {
  std::string address = triangulation_path(triangulation) + "/files";
  while (!path.empty()) {
    const std::size_t end = std::min(path.find('/'), path.size());
    address += "/" + encode_segment(path.substr(0, end));
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  return address;
}

Links::Links(std::string public_url) : public_url_(std::move(public_url)) {
  while (public_url_.ends_with('/')) public_url_.pop_back();
}

std::string Links::to(const Request& request, std::string_view path) const {
  if (!public_url_.empty()) return public_url_ + std::string(path);
  return relative_reference(request.target.path, path);
}

proto::Link Links::link(const Request& request, std::string_view path, std::string rel, std::string type,
                        std::string title) const {
  proto::Link link;
  link.set_href(to(request, path));
  link.set_rel(std::move(rel));
  link.set_type(std::move(type));
  link.set_title(std::move(title));
  return link;
}

void Links::add(const Request& request, proto::StatusInfo& job) const {
  const std::string self = job_path(job.job_id());
  job.clear_links();
  *job.add_links() = link(request, self, "self", json, "This job");
  *job.add_links() = link(request, self + "/events", "events", "text/event-stream", "What happens to it");
  *job.add_links() = link(request, self + "/log", "runlog", "text/plain", "Its log");
  if (job.status() == "successful")
    *job.add_links() =
        link(request, self + "/results", "http://www.opengis.net/def/rel/ogc/1.0/results", json, "Its results");
  if (job.resumable() && is_terminal(job.status()))
    *job.add_links() = link(request, self + "/resume", "resume", json, "Go on with it (POST)");
  if (job.has_problem()) job.mutable_problem()->set_instance(self);
}

void Links::add(const Request& request, proto::TriangulationInfo& triangulation) const {
  const std::string self = triangulation_path(triangulation.name());
  triangulation.clear_links();
  *triangulation.add_links() = link(request, self, "self", json, "This triangulation");
  *triangulation.add_links() = link(request, file_path(triangulation.name(), manifest_file({}).string()), "describedby",
                                    json, "Its manifest, which names its files");
  *triangulation.add_links() = link(request, file_path(triangulation.name(), master_file({}).string()), "item",
                                    "application/xml", "Its master file, for ParaView");
  *triangulation.add_links() =
      link(request, self + "/versions", "version-history", json, "Its versions, and what has changed it");
  *triangulation.add_links() = link(request, self + "/exports", "exports", json, "What it was made into");
  if (triangulation.has_live())
    *triangulation.add_links() =
        link(request, self + "/events", "events", "text/event-stream", "Its versions, as they are made");
}

}  // namespace tessera::service::http
