// Points of live results: they are added and removed, and whoever follows a result hears of its versions.
#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/service/http/handlers.h"

namespace tessera::service::http {
namespace {

constexpr const char* npy_file = "application/x-npy";

Handler changes_points(Reply<proto::PointsChanged> (LiveBackend::*change)(std::string_view, const PointsBody&,
                                                                          const Caller&)) {
  return [change](const Call& call) {
    const std::string type = media_type(call.request.header("content-type"));
    if (type != json && type != npy_file && type != protobuf_type)
      return problem(415, std::string("Content-Type: must be one of ") + json + ", " + npy_file + ", " + protobuf_type,
                     2);
    const std::string_view replace = call.request.target.parameter("replace").value_or("false");
    if (replace != "true" && replace != "false") return problem(400, "replace: must be true or false", 2);
    const Reply<proto::PointsChanged> changed = (call.context.backend->live.*change)(
        call.arguments[0], PointsBody{type, call.request.body, replace == "true"}, call.request.caller);
    return changed ? message_answer(call.request, 200, changed.value()) : problem(changed.error());
  };
}

Answer follow(const Call& call, Shared& shared) {
  const std::string_view last_id = call.request.header("last-event-id");
  std::optional<std::uint64_t> last;
  if (!last_id.empty()) {
    std::uint64_t number = 0;
    const auto [end, failed] = std::from_chars(last_id.data(), last_id.data() + last_id.size(), number);
    if (failed != std::errc() || end != last_id.data() + last_id.size())
      return problem(400, "Last-Event-ID: is not the number of a version", 2);
    last = number;
  }
  auto queue = std::make_shared<EventQueue>(shared.texts, "", EventQueue::Limits{});
  // The queue outlives the subscription that it holds.
  Reply<std::unique_ptr<Subscription>> subscription = call.context.backend->live.follow(
      call.arguments[0], last,
      [to = queue.get()](const std::shared_ptr<const proto::Event>& event) { to->add(event); });
  if (!subscription) return problem(subscription.error());
  queue->keep(std::move(subscription.value()));
  Answer answer;
  answer.headers = {{"Content-Type", "text/event-stream"}, {"X-Accel-Buffering", "no"}, {"Cache-Control", "no-store"}};
  answer.events = std::move(queue);
  answer.close = true;
  return answer;
}

}  // namespace

void add_live_routes(std::vector<Route>& routes, Shared& shared) {
  const std::string path = "/v1/triangulations/{triangulation}/";
  const Response changed{200, json, "PointsChanged", "The version that has the change, which survives from now on"};
  Route add{"POST",
            path + "points",
            Role::submit,
            "addPoints",
            "Add points to a live result",
            {changed},
            changes_points(&LiveBackend::add)};
  add.body = "NewPoints";
  add.query = {{"replace", "boolean", "Remove the points of the result that are equal to new ones"}};
  Route remove{"DELETE",
               path + "points",
               Role::submit,
               "removePoints",
               "Remove points from a live result",
               {changed},
               changes_points(&LiveBackend::remove)};
  remove.body = "PointIds";
  for (Route* route : {&add, &remove}) {
    route->body_types = {npy_file, protobuf_type};
    route->runs = Runs::points;
    routes.push_back(std::move(*route));
  }
  Route events{"GET",
               path + "events",
               Role::read,
               "followTriangulation",
               "The versions of a live result, and the boxes in which cells have changed, as they are made",
               {{200, "text/event-stream", "", "The events, as they come"}},
               [&shared](const Call& call) { return follow(call, shared); }};
  routes.push_back(std::move(events));
}

}  // namespace tessera::service::http
