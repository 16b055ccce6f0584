#include "src/front/apps/interrupt.h"

#include <unistd.h>

#include <utility>  // Boost 1.74's Asio needs it and does not include it
//
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <csignal>
#include <thread>

#include "src/base/result.h"
#include "src/input/bytes/objects.h"

namespace tessera::apps {

struct Interrupt::Impl {
  boost::asio::io_context context;
  boost::asio::signal_set signals{context, SIGINT, SIGTERM};
  std::stop_source source;
  std::jthread thread;

  void wait() {
    signals.async_wait([this](const boost::system::error_code& error, int) {
      if (error) return;
      if (source.stop_requested()) _exit(static_cast<int>(Errc::interrupted));
      source.request_stop();
      wait();
    });
  }
};

Interrupt::Interrupt() : impl_(std::make_unique<Impl>()) {
  impl_->wait();
  stop_objects_by(impl_->source.get_token());
  impl_->thread = std::jthread([impl = impl_.get()] { impl->context.run(); });
}

Interrupt::~Interrupt() {
  stop_objects_by({});
  impl_->context.stop();
}

std::stop_token Interrupt::token() const { return impl_->source.get_token(); }

}  // namespace tessera::apps
