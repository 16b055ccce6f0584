// The client's view of a daemon: its requests, answered with messages and errors. One call at a time.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "service.pb.h"
#include "src/base/result.h"
#include "src/service/client/address.h"
#include "src/service/client/connection.h"

namespace tessera::client {

struct ServerOptions {
  ServerAddress address;
  std::string token;  // used instead of the address's; "" for none
  std::filesystem::path authorities;
  // How long to wait for a server that has answered before and is gone.
  std::chrono::seconds patience{600};
  // Advice for errors: how to give a token, and authorities.
  std::string token_advice, authorities_advice;
};

// A random key. A job that is submitted again with the same key does not become two jobs.
std::string new_idempotency_key();

// Errors of all calls: those of Connection; and the server's problems, with their cause as the code; without a cause
// usage for mistakes of the caller, and io for others. Usage when the peer is no Tessera server.
class Server {
 public:
  static Result<Server> make(ServerOptions options);

  const ServerAddress& address() const { return options_.address; }

  // `inputs` becomes the object of that name in the request.
  Result<proto::StatusInfo> submit(const std::string& process, const nlohmann::ordered_json& inputs,
                                   const std::string& idempotency_key, const std::stop_token& stop);
  // At most `limit` jobs, newest first, with one of these states (all when empty).
  Result<std::vector<proto::StatusInfo>> jobs(const std::vector<std::string>& states, std::size_t limit,
                                              const std::stop_token& stop);
  Result<proto::StatusInfo> job(const std::string& id, const std::stop_token& stop);
  // The server forgets a job that has ended: check the state first.
  Result<proto::StatusInfo> dismiss(const std::string& id, const std::stop_token& stop);
  Result<proto::StatusInfo> resume(const std::string& id, const std::stop_token& stop);
  // What a verify, export or info job found.
  Result<nlohmann::ordered_json> outcome(const std::string& id, const std::stop_token& stop);
  // What `info` says of these inputs; or, when that takes long, the job that finds it out.
  struct Told {
    nlohmann::ordered_json now;
    std::optional<proto::StatusInfo> job;
  };
  Result<Told> info(const nlohmann::ordered_json& inputs, const std::stop_token& stop);
  // Delivers the events of a job until on_event returns true (enough) or an error. Begins with the current status, as
  // an event without id. When the server was gone, calls on_gone with the reason, and begins again.
  using OnEvent = std::function<Result<bool>(const proto::Event&)>;
  Status events(const std::string& id, const OnEvent& on_event, const std::function<void(const std::string&)>& on_gone,
                const std::stop_token& stop);

  Result<std::vector<proto::TriangulationInfo>> triangulations(const std::stop_token& stop);
  // Nothing when there is no triangulation of this name.
  Result<std::optional<proto::TriangulationInfo>> triangulation(const std::string& name, const std::stop_token& stop);
  // The entries of a folder that jobs may read, by name; "": the entries of all roots.
  // The versions of a result, as `tessera log --json` prints them.
  Result<nlohmann::ordered_json> versions(const std::string& name, const std::stop_token& stop);
  Result<std::vector<proto::InputInfo>> inputs(const std::string& folder, const std::stop_token& stop);
  // The nodes that work on jobs, in the order in which they joined.
  Result<std::vector<proto::NodeInfo>> nodes(const std::stop_token& stop);
  // Takes all work from a node, given by name or id, and ends its process. Returns the node.
  Result<proto::NodeInfo> drain(const std::string& node, const std::stop_token& stop);

  // Requests a file of a result from byte `from` on. `etag` identifies the wanted file ("" for any). When the server
  // has another file, it sends it from byte 0, and the receiver's head has status 200.
  Result<HttpAnswer> file(const std::string& triangulation, const std::string& path, std::uint64_t from,
                          const std::string& etag, const HttpReceiver& receiver, const std::stop_token& stop);

  // Removes an export of a result.
  Status remove_export(const std::string& triangulation, const std::string& file, const std::stop_token& stop);

  // The number of bytes of an upload that have come.
  Result<std::uint64_t> uploaded(const std::string& folder, const std::string& file, const std::stop_token& stop);
  // Sends the bytes of an upload after `from` (0: begins anew). `answer` is the server's status, or 0 when none came:
  // then the upload may be continued.
  Status upload(const std::string& folder, const std::string& file, std::uint64_t from, std::uint64_t bytes,
                std::function<Result<std::size_t>(std::span<char>)> source, int& answer, const std::stop_token& stop);
  std::chrono::seconds patience() const { return options_.patience; }

 private:
  Server(ServerOptions options, Connection connection, Connection watching);
  static bool is_json(const HttpHead& head);
  static Errc code_of(int status, int cause);
  // Returns any answer.
  Result<HttpAnswer> answer_to(HttpRequest request, const std::stop_token& stop, const HttpReceiver& receiver = {});
  // Returns an answer with JSON and status 2xx.
  Result<HttpAnswer> ask(HttpRequest request, const std::stop_token& stop);
  template <class Message>
  Result<Message> ask_for(HttpRequest request, const std::stop_token& stop);
  template <class List, class Member>
  Result<std::vector<Member>> ask_for_all(std::string target, std::size_t limit, const std::stop_token& stop);
  Result<bool> listen(const std::string& id, std::string& last_id, bool& heard, const OnEvent& on_event,
                      const std::stop_token& stop);
  std::string target(const std::string& path) const { return options_.address.base + "/v1" + path; }
  std::string upload_target(const std::string& folder, const std::string& file) const {
    return target("/uploads/" + percent_encoded(folder) + "/" + percent_encoded(file));
  }
  std::string file_target(const std::string& triangulation, const std::string& path) const;
  HttpRequest execution(const std::string& process, const nlohmann::ordered_json& inputs) const;
  void authorize(HttpRequest& request) const;
  Error refusal(const HttpAnswer& answer) const;
  Error no_tessera() const;
  Error with_advice(Error failed) const;

  ServerOptions options_;
  Connection connection_, watching_;  // the second listens to events, while the first asks
  bool heard_ = false;                // the server has answered a request
};

}  // namespace tessera::client
