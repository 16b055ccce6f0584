// The table of routes: what there is, who may, who answers, and what the documents say of it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "src/service/http/links.h"
#include "src/service/http/message.h"
#include "src/service/service.h"

namespace tessera::http {

// What a handler needs beside the request.
struct Context {
  Backend* backend;  // null where only health and figures are served
  const Links& links;
};

struct Call {
  const Request& request;
  const std::vector<std::string>& arguments;  // what stands in the braces of the path, in order
  const Context& context;
};

struct Parameter {
  std::string name, type, description;  // type: of JSON schema
};

struct Response {
  int status = 200;
  std::string type;    // media type; empty: no content
  std::string schema;  // its name in the document; empty: not JSON
  std::string description;
};

// Where a route is found: with the API, or on the listener that supervisors and Prometheus see.
enum class Place : std::uint8_t { api, operations };

using Handler = std::function<Answer(const Call&)>;
// Begins to take a body of any length.
using UploadHandler = std::function<Reply<std::unique_ptr<Backend::Upload>>(const Call&)>;

// Where a handler runs, which may wait for a disk, or for who writes to one.
enum class Runs : std::uint8_t {
  at_once,   // never waits: by a thread that serves connections
  health,    // beside all others
  disk,      // for a short time
  changes,   // in turn with other callers, here and below: what reads inputs, makes jobs or removes what is there
  questions  // to results
};
// Callers take turns, and its stop token tells when its caller has gone.
constexpr bool in_turn(Runs runs) { return runs == Runs::changes || runs == Runs::questions; }

struct Route {
  std::string method, path;  // "/v1/jobs/{job}"; a last "{path*}" takes all that is left
  Role role = Role::admin;   // the least that is allowed to
  std::string name, summary;
  std::vector<Response> responses;
  Handler handler;
  std::vector<Parameter> query = {};
  std::string body = {};                     // the name of the schema of what is sent
  std::vector<std::string> body_types = {};  // media types that it may have beside JSON; none: protobuf
  Place place = Place::api;
  Runs runs = Runs::disk;
  UploadHandler upload = {};  // instead of reading the body for `handler`, which then answers once all is taken
};

class Router {
 public:
  explicit Router(std::vector<Route> routes);

  const std::vector<Route>& routes() const { return routes_; }
  // Of the routes whose path fits, the one of `method` (GET for HEAD where there is no HEAD), with the arguments.
  // `allowed` gets the methods of them all; empty: 404.
  const Route* find(Place place, std::string_view method, const std::vector<std::string>& segments,
                    std::vector<std::string>& arguments, std::vector<std::string>& allowed) const;

 private:
  std::vector<Route> routes_;
  std::vector<std::vector<std::string>> templates_;  // of each route, its segments
};

}  // namespace tessera::http
