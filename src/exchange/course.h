// How far a job is, as its coordinator sees it. A plain state machine without I/O and threads.
#pragma once

#include <cstdint>
#include <stdexcept>

namespace tessera {

class Course {
 public:
  enum class At : std::uint8_t {
    finding,     // a coordinator that takes over finds out which nodes have shares
    opening,     // the nodes open their shares
    exchanging,  // tiles exchange messages; this state and the next two come again in each stage
    settling,    // all is quiet: tiles write down what they need to end without other tiles
    collecting,  // tiles come to the end of the stage
    finishing,   // the last stage is over: shares end
    ending       // the job ends early: it failed, or was stopped
  };

  explicit Course(At at) : at_(at) {}
  At at() const { return at_; }
  bool is(At at) const { return at_ == at; }
  // Returns whether nothing more is begun.
  bool ends() const { return at_ >= At::finishing; }
  // Returns whether tiles are at work.
  bool works() const { return at_ == At::exchanging || at_ == At::settling || at_ == At::collecting; }

  void open() { go(At::finding, At::opening); }
  // All shares are open, or found. `settled` says whether an earlier process has settled all tiles.
  void begin(bool settled) {
    require(at_ == At::finding || at_ == At::opening);
    at_ = settled ? At::collecting : At::exchanging;
  }
  void settle() { go(At::exchanging, At::settling); }
  void collect() { go(At::settling, At::collecting); }
  // Some tiles begin again. Returns true when all was believed quiet; the job then goes back to exchanging.
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
  // Callers check the state first. A violation is an exception and no abort, so that it ends the job and not the
  // process.
  static void require(bool holds) {
    if (!holds) throw std::logic_error("the steps of a job follow each other");
  }

  At at_;
};

}  // namespace tessera
