#include <algorithm>
#include <utility>

#include "src/service/http/handlers.h"
#include "src/service/http/ranges.h"
#include "web/web_files.h"

namespace tessera::service::http {
namespace {

constexpr std::string_view page = "index.html";
// Only the dashboard's own files and this service; no script or style in the page itself. Text that comes from jobs
// cannot become markup.
constexpr const char* policy =
    "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'; object-src 'none'; "
    "require-trusted-types-for 'script'";

Answer file_of(const Request& request, std::string_view name) {
  const auto files = web_files();
  const auto found = std::find_if(files.begin(), files.end(), [&](const WebFile& file) { return file.name == name; });
  if (found == files.end()) return problem(404, "the dashboard has no file '" + std::string(name) + "'");
  Answer answer;
  answer.headers = {{"ETag", std::string(found->etag)},
                    {"Cache-Control", "no-cache"},  // another version of the daemon has other files under these names
                    {"Content-Security-Policy", policy}};
  if (names_tag(request.header("if-none-match"), found->etag, true)) {
    answer.status = 304;
    return answer;
  }
  answer.headers.emplace_back("Content-Type", std::string(found->type));
  answer.body = std::string(found->bytes);
  return answer;
}

Answer dashboard(const Call& call) {
  if (call.request.target.path.ends_with('/')) return file_of(call.request, page);
  Answer answer;
  answer.status = 303;
  answer.headers.emplace_back("Location", "ui/");  // its files have relative links
  return answer;
}

Answer dashboard_file(const Call& call) { return file_of(call.request, call.arguments[0]); }

}  // namespace

void add_dashboard_routes(std::vector<Route>& routes) {
  const Response unchanged{304, "", "", "The file is the one that If-None-Match names"};
  Route ui{"GET",
           "/ui",
           Role::none,
           "getDashboard",
           "The dashboard, a page for browsers",
           {{200, "text/html", "", "The page"}, {303, "", "", "The page is at /ui/"}, unchanged},
           dashboard};
  Route part{"GET",
             "/ui/{file}",
             Role::none,
             "getDashboardFile",
             "A file of the dashboard",
             {{200, "text/javascript", "", "The file"}, unchanged},
             dashboard_file};
  for (Route* route : {&ui, &part}) {
    route->runs = Runs::at_once;
    routes.push_back(std::move(*route));
  }
}

}  // namespace tessera::service::http
