// The table of routes: paths, required roles, handlers, and descriptions for the documents.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "src/service/backend.h"
#include "src/service/http/links.h"
#include "src/service/http/message.h"

namespace tessera::service::http {

// What handlers need in addition to the request.
struct Context {
  const Backend* backend;  // null where only health and figures are served
  const Links& links;
};

struct Call {
  const Request& request;
  const std::vector<std::string>& arguments;  // the parts of the path for the braces, in order
  const Context& context;
};

struct Parameter {
  std::string name, type, description;  // type of JSON schema
};

struct Response {
  int status = 200;
  std::string type;    // media type; empty: no content
  std::string schema;  // name of the schema in the document; empty: not JSON
  std::string description;
};

// Where a route is served: with the API, or on the listener for supervisors and Prometheus.
enum class Place : std::uint8_t { api, operations };

using Handler = std::function<Answer(const Call&)>;
// Begins to receive a body of any length.
using UploadHandler = std::function<Reply<std::unique_ptr<Upload>>(const Call&)>;

// Where a handler runs. A handler may wait for a disk, or for another thread that writes to a disk.
enum class Runs : std::uint8_t {
  at_once,    // never waits: on a thread that serves connections
  health,     // beside all others
  disk,       // for a short time
  changes,    // in turn with other callers, here and below: reads inputs, makes jobs or removes files
  questions,  // to results
  points      // as `changes`, for a short time and many at once: adds and removes points of live results
};
// True if callers take turns. Then the caller's stop token says when the caller has gone.
constexpr bool in_turn(Runs runs) { return runs >= Runs::changes; }

struct Route {
  std::string method, path;  // "/v1/jobs/{job}"; a last "{path*}" matches the rest of the path
  Role role = Role::admin;   // the lowest role that is allowed
  std::string name, summary;
  std::vector<Response> responses;
  Handler handler;
  std::vector<Parameter> query = {};
  std::string body = {};                     // the name of the body's schema
  std::vector<std::string> body_types = {};  // media types that the body may have in addition to JSON; none: protobuf
  Place place = Place::api;
  Runs runs = Runs::disk;
  UploadHandler upload = {};  // if set, receives the body; `handler` answers after it
};

class HttpRouter {
 public:
  explicit HttpRouter(std::vector<Route> routes);

  const std::vector<Route>& routes() const { return routes_; }
  // Finds the route for `method` among the routes with this path (GET for HEAD where there is no HEAD), and its
  // arguments. `allowed` gets the methods of all routes with this path; empty means 404.
  const Route* find(Place place, std::string_view method, const std::vector<std::string>& segments,
                    std::vector<std::string>& arguments, std::vector<std::string>& allowed) const;

 private:
  std::vector<Route> routes_;
  std::vector<std::vector<std::string>> templates_;  // segments by route
};

}  // namespace tessera::service::http
