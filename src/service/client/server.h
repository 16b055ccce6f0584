// A daemon, as its client sees it: what can be asked of it, answered with messages and errors. One call at a time.
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

namespace tessera {

struct ServerOptions {
  ServerAddress address;
  std::string token;  // in place of the address's; "" for none
  std::filesystem::path authorities;
  // How long a server that has answered and is gone is waited for.
  std::chrono::seconds patience{600};
  // What errors advise: how a token, and authorities, are given.
  std::string token_advice, authorities_advice;
};

// A random key under which the same job can be submitted again without becoming two.
std::string new_idempotency_key();

// Errors of all calls: those of Connection; and what the server's problem says, with its cause as code, or usage for
// one without cause that is the caller's mistake, io for others. Usage when what answers is no Tessera server.
class Server {
 public:
  static Result<Server> make(ServerOptions options);

  const ServerAddress& address() const { return options_.address; }

  // `inputs`: the object of that name in the request.
  Result<proto::StatusInfo> submit(const std::string& process, const nlohmann::ordered_json& inputs,
                                   const std::string& idempotency_key, const std::stop_token& stop);
  // At most `limit`, newest first as the server has them; of these states (all when empty).
  Result<std::vector<proto::StatusInfo>> jobs(const std::vector<std::string>& states, std::size_t limit,
                                              const std::stop_token& stop);
  Result<proto::StatusInfo> job(const std::string& id, const std::stop_token& stop);
  // Of a job that has ended the server forgets: look first.
  Result<proto::StatusInfo> dismiss(const std::string& id, const std::stop_token& stop);
  Result<proto::StatusInfo> resume(const std::string& id, const std::stop_token& stop);
  // What a verify, export or info job found.
  Result<nlohmann::ordered_json> outcome(const std::string& id, const std::stop_token& stop);
  // What `info` tells of these inputs; or, of those that take long, the job that finds it out.
  struct Told {
    nlohmann::ordered_json now;
    std::optional<proto::StatusInfo> job;
  };
  Result<Told> info(const nlohmann::ordered_json& inputs, const std::stop_token& stop);
  // Tells of the job until on_event says that it has heard enough (true), or fails. Begins with the status there is, as
  // an event without id; also each time after the server was gone, which on_gone tells, with the reason.
  using OnEvent = std::function<Result<bool>(const proto::Event&)>;
  Status events(const std::string& id, const OnEvent& on_event, const std::function<void(const std::string&)>& on_gone,
                const std::stop_token& stop);

  Result<std::vector<proto::TriangulationInfo>> triangulations(const std::stop_token& stop);
  // Nothing when there is none of this name.
  Result<std::optional<proto::TriangulationInfo>> triangulation(const std::string& name, const std::stop_token& stop);
  // What a folder holds that jobs may read, by name; "": of all that the server reads from.
  Result<std::vector<proto::InputInfo>> inputs(const std::string& folder, const std::stop_token& stop);
  // Who works on the jobs, in order of coming.
  Result<std::vector<proto::NodeInfo>> nodes(const std::stop_token& stop);
  // Takes all work from a node, by its name or id, and lets its process end. What it was.
  Result<proto::NodeInfo> drain(const std::string& node, const std::stop_token& stop);

  // A file of a result, from its byte `from` on. `etag` ("" for any): of the file that is meant; the receiver's head
  // tells by 200 that the server begins at 0, having another.
  Result<HttpAnswer> file(const std::string& triangulation, const std::string& path, std::uint64_t from,
                          const std::string& etag, const HttpReceiver& receiver, const std::stop_token& stop);

  // Removes what a result was exported to.
  Status remove_export(const std::string& triangulation, const std::string& file, const std::stop_token& stop);

  // How many bytes of an upload have come.
  Result<std::uint64_t> uploaded(const std::string& folder, const std::string& file, const std::stop_token& stop);
  // Sends what comes after `from` bytes of an upload (0: all of it anew). `answer` is the server's status, 0 when none
  // came: then it may be gone on with.
  Status upload(const std::string& folder, const std::string& file, std::uint64_t from, std::uint64_t bytes,
                std::function<Result<std::size_t>(std::span<char>)> source, int& answer, const std::stop_token& stop);
  std::chrono::seconds patience() const { return options_.patience; }

 private:
  Server(ServerOptions options, Connection connection, Connection watching);
  static bool is_json(const HttpHead& head);
  static Errc code_of(int status, int cause);
  // Whatever it is.
  Result<HttpAnswer> answer_to(HttpRequest request, const std::stop_token& stop, const HttpReceiver& receiver = {});
  // JSON, of status 2xx.
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
  Connection connection_, watching_;  // one listens to events while the other asks
  bool heard_ = false;                // it has answered something
};

}  // namespace tessera
