// What must be done before a node may leave a job in order: other nodes then go on with what the node has, and none of
// it begins again.
//
// the job    | what must be done before the node may go
// finding    | wait until it is known where the shares are. The node is asked for its share, too, because it may have
//            | told the coordinator before this one that it leaves
// opening    | nothing, because no tile has begun: its tiles go to others
// exchanging | its share hands over: it writes an image of each tile that has begun, and ends. A table of a new epoch
//            | then places the tiles elsewhere, as other incarnations, which begin from these images
// settling   | wait
// collecting | the node stores what it has
// finishing, ending | wait
#pragma once

#include <cstdint>

#include "src/exchange/course.h"
#include "src/exchange/placements.h"
#include "src/exchange/roster.h"

namespace tessera {

enum class LeaveStep : std::uint8_t {
  dismiss,    // the node has begun nothing: its share is given up, and the node may go
  hand_over,  // tell its share to hand over
  finish,     // its share has stored what it has, and is told to end
  wait
};

// Returns what is to be done now for a node that wants to leave, and notes in roster and placements that it is done.
// REQUIRES: the job is not finding shares, and the roster has the node.
LeaveStep next_leave_step(const Course& course, Roster& roster, Placements& placements, NodeId node);

}  // namespace tessera
