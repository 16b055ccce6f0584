#include "src/exchange/leaving.h"

#include <utility>

namespace tessera {

LeaveStep next_leave_step(const Course& course, Roster& roster, Placements& placements, NodeId node) {
  if (course.ends()) return LeaveStep::wait;
  Roster::Node& known = roster[node];
  if (course.is(Course::At::opening) || !known.there()) return LeaveStep::dismiss;
  if (course.is(Course::At::exchanging) && placements.begin_handing(node)) return LeaveStep::hand_over;
  if (course.is(Course::At::collecting) && known.reached == Roster::Reached::collected &&
      !std::exchange(known.dismissed, true))
    return LeaveStep::finish;
  return LeaveStep::wait;
}

}  // namespace tessera
