// How far a job is, as its coordinator sees it. Pure.
#pragma once

#include <cstdint>
#include <stdexcept>

namespace tessera {

class Course {
 public:
  enum class At : std::uint8_t {
    finding,     // of a coordinator that takes over: which nodes have parts
    opening,     // the parts
    exchanging,  // messages between tiles; and below, of one stage after the other
    settling,    // all is quiet: tiles write down what their end can be made from alone
    collecting,  // tiles come to their end
    finishing,   // the last stage is over: parts end
    ending       // for a failure, or because somebody said so
  };

  explicit Course(At at) : at_(at) {}
  At at() const { return at_; }
  bool is(At at) const { return at_ == at; }
  // Nothing more is begun.
  bool ends() const { return at_ >= At::finishing; }
  // Tiles are at work.
  bool works() const { return at_ == At::exchanging || at_ == At::settling || at_ == At::collecting; }

  void open() { go(At::finding, At::opening); }
  // The parts are open, or found. `settled`: all tiles were in an earlier process.
  void begin(bool settled) {
    require(at_ == At::finding || at_ == At::opening);
    at_ = settled ? At::collecting : At::exchanging;
  }
  void settle() { go(At::exchanging, At::settling); }
  void collect() { go(At::settling, At::collecting); }
  // Some tiles begin again. True: all were believed quiet.
  bool disturb() {
    if (at_ != At::settling) return false;
    at_ = At::exchanging;
    return true;
  }
  void begin_next_stage() { go(At::collecting, At::exchanging); }
  void finish() { go(At::collecting, At::finishing); }
  void end() { at_ = At::ending; }

 private:
  void go(At from, At to) {
    require(at_ == from);
    at_ = to;
  }
  // Whoever calls it has looked. An exception ends the job, and not the process.
  static void require(bool holds) {
    if (!holds) throw std::logic_error("the steps of a job follow each other");
  }

  At at_;
};

}  // namespace tessera
