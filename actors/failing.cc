#include "actors/failing.h"

namespace tessera {
namespace {

std::string in_words(caf::exit_reason reason) {
  switch (reason) {
    case caf::exit_reason::normal:
    case caf::exit_reason::user_shutdown:
      return "it has ended";
    case caf::exit_reason::kill:
      return "it was ended";
    case caf::exit_reason::out_of_workers:
    case caf::exit_reason::remote_link_unreachable:
      return "the connection is broken";
    case caf::exit_reason::unhandled_exception:
      return "an unexpected error";
    case caf::exit_reason::unknown:
    case caf::exit_reason::unreachable:
      break;
  }
  return "it is gone";
}

std::string in_words(caf::sec reason) {
  switch (reason) {
    case caf::sec::cannot_connect_to_node:
      return "no process listens there, or the network does not reach it";
    case caf::sec::disconnect_during_handshake:
      return "the connection was closed before any message came: the certificates may not match";
    case caf::sec::request_timeout:
    case caf::sec::connection_timeout:
      return "no answer in time";
    case caf::sec::no_actor_published_at_port:
    case caf::sec::unexpected_actor_messaging_interface:
    case caf::sec::incompatible_versions:
    case caf::sec::incompatible_application_ids:
      return "the process that listens there belongs to no cluster, or to another release";
    case caf::sec::malformed_basp_message:
    case caf::sec::serializing_basp_payload_failed:
    case caf::sec::unknown_type:
    case caf::sec::end_of_stream:
    case caf::sec::invalid_argument:
    case caf::sec::unexpected_message:
      return "a message was not understood";
    case caf::sec::request_receiver_down:
    case caf::sec::no_route_to_receiving_node:
    case caf::sec::socket_disconnected:
    case caf::sec::remote_linking_failed:
      return "the connection is broken";
    case caf::sec::network_syscall_failed:
    case caf::sec::socket_operation_failed:
    case caf::sec::cannot_open_port:
      return "the system refuses it";
    case caf::sec::runtime_error:
      return "an unexpected error";
    default:
      return "network error " + std::to_string(static_cast<unsigned>(reason));
  }
}

}  // namespace

std::string in_words(const caf::error& reason) {
  if (!reason) return "it has ended";  // such an error has no category either
  if (reason.category() == caf::atom("exit")) return in_words(static_cast<caf::exit_reason>(reason.code()));
  if (reason.category() == caf::atom("system")) return in_words(static_cast<caf::sec>(reason.code()));
  return "error " + std::to_string(reason.code());
}

Failure lost(const std::string& who, const caf::error& reason) {
  return failure_of(error(Errc::internal, who + " ended unexpectedly: " + in_words(reason)));
}

}  // namespace tessera
