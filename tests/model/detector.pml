// Quiescence without losses (docs/cluster-design.md): actors/share_actor.h, src/exchange/detector.h, and the credit window.
// A tile a node. Batches look alike, so a channel that need not keep their order is a number.
// With CHANGE it is the exchange of a change of a stored result (src/delaunay/update/changed_program.h): every tile gets
// a permit to begin. Tiles with fresh points call themselves then, and have their points from the step on that this
// makes. The others do nothing, and sleep. Their own points come late: in the step that takes in their first mail.
#define NODES 3
#ifndef BATCHES  // updates sent at most, of all tiles together
#define BATCHES 5
#endif
#ifndef WINDOW  // batches under way from one node to another: credit comes back when one is taken in
#define WINDOW 2
#endif
#ifndef FRESH  // tiles that have not begun yet; the others wait for mail
#define FRESH 3
#endif
#define PAIR(from, to) ((from) * NODES + (to))

mtype = { grant, notice, report };

byte budget = BATCHES;
byte outbox[NODES * NODES];  // posted, and wait for credit
byte wire[NODES * NODES];
byte mail[NODES];  // what the tile has
byte sent[NODES], processed[NODES];  // what the tile counts
byte live;  // ghost: batches sent and not processed
byte at_work;  // ghost

// Messages from one actor to another keep their order.
chan to_tile[NODES] = [1] of { mtype };
chan to_part[NODES] = [3] of { mtype, byte, byte, byte };  // of mail, sent, processed
#ifdef CHANGE
bool call[NODES];  // a tile's empty update to itself is under way
#define BEGINS true
#else
#define BEGINS (me < FRESH)
#endif
bool probe[NODES];
bool idle_notice[NODES];  // is under way
bool told_idle[NODES];    // since its last answer
byte known_idle;          // to the coordinator: a mask
bool noticed;             // since the last wave began
// Answers add up in any order: that they are under way is seen in when the last is judged.
byte answers, sum_sent, sum_processed;
bool all_idle;

inline post() {
  budget--;
  live++;
  outbox[PAIR(me, peer)]++;
#ifndef COUNT_AT_GATE
  sent[me]++;
#endif
  give(me, peer);
  peer = 0
}

// The gate: what has credit is on its way. Nobody could see that it goes any later.
inline give(from, to) {
  if
  :: outbox[PAIR(from, to)] > 0 && wire[PAIR(from, to)] < WINDOW ->
    outbox[PAIR(from, to)]--;
#ifdef COUNT_AT_GATE
    sent[from]++;
#endif
    wire[PAIR(from, to)]++
  :: else
  fi
}

// Taken in at once, whatever waits to go out.
inline take_in(from) {
  wire[PAIR(from, me)]--;
  give(from, me);
  put_into_mail()
}

inline put_into_mail() {
  mail[me]++;
  if
  :: told
  :: else -> told = true; to_part[me] ! notice(mail[me], 0, 0)
  fi
}

inline tell_report() {
  processed[me] = processed[me] + taken;
  live = live - taken;
  taken = 0;
  told = mail[me] > 0;
  to_part[me] ! report(mail[me], sent[me], processed[me])
}

#ifdef CHANGE
inline call_itself() {
  if
  :: me < FRESH ->
    call[me] = true;
    live++;
#ifndef CALL_NOT_COUNTED
    sent[me]++
#endif
  :: else
  fi
}
#endif

#ifdef RECEIVING_WAITS
#define MAY_RECEIVE (wire[PAIR(me, 0)] + wire[PAIR(me, 1)] + wire[PAIR(me, 2)] == 0)
#else
#define MAY_RECEIVE true
#endif

proctype tile(byte me) {
  byte peer, taken;
  bool told, begun = !BEGINS, has_points = true;
#ifdef CHANGE
  has_points = false;
#endif
end:
  do
  :: to_tile[me] ? grant ->
    atomic {
      at_work++;
      if
      :: begun -> taken = mail[me]; mail[me] = 0
      :: else -> begun = true  // mail waits for the first splay
#ifdef CHANGE
        ; call_itself()
#endif
      fi
    }
#ifdef CHANGE
    atomic {
      if
      :: taken > 0 && !has_points ->
        has_points = true;
#ifdef WAKES_AFTER_REPORT
        tell_report()
#endif
      :: else
      fi
    }
#endif
    do  // others see each post before the report
    :: atomic {
        budget > 0 && has_points ->
        if
        :: peer = (me + 1) % NODES
        :: peer = (me + 2) % NODES
        fi;
        post()
      }
    :: break
    od;
    atomic {
      at_work--;
      tell_report()
    }
#ifdef CHANGE
  :: atomic { call[me] -> call[me] = false; put_into_mail() }
#endif
  :: atomic { MAY_RECEIVE && wire[PAIR((me + 1) % NODES, me)] > 0 -> take_in((me + 1) % NODES) }
  :: atomic { MAY_RECEIVE && wire[PAIR((me + 2) % NODES, me)] > 0 -> take_in((me + 2) % NODES) }
  od
}

inline dispatch() {
  if
  :: working
  :: !working && waiting > 0 -> working = true; waiting = 0; to_tile[me] ! grant
  :: else ->
    if
    :: told_idle[me]
    :: else -> told_idle[me] = true; idle_notice[me] = true
    fi
  fi
}

// What a node says comes in its order: a notice before an answer, if it was said before.
inline hear_notice(n) {
  idle_notice[n] = false;
  known_idle = known_idle | (1 << (n));
  noticed = true
}

proctype part(byte me) {
  byte waiting, known_sent, known_processed, of_mail;
  bool working = BEGINS;
  if
#ifdef BEGINS_UNSEEN
  :: working -> atomic { working = false; told_idle[me] = true; idle_notice[me] = true }; to_tile[me] ! grant
#endif
  :: working -> to_tile[me] ! grant
  :: else -> atomic { told_idle[me] = true; idle_notice[me] = true }  // BeginPart, with nothing to do
  fi;
end:
  do
  :: atomic {
      to_part[me] ? notice(of_mail, _, _) ->
      if
      :: working  // the report will tell
      :: else -> waiting = of_mail
      fi;
      of_mail = 0;
      dispatch()
    }
  :: atomic { to_part[me] ? report(waiting, known_sent, known_processed) -> working = false; dispatch() }
  :: d_step {
      probe[me] ->
      probe[me] = false;
      answers++;
      if
      :: idle_notice[me] -> hear_notice(me)
      :: else
      fi;
#ifndef SILENT_AFTER_ANSWER
      told_idle[me] = false;
#endif
      if
      :: working || waiting > 0 -> known_idle = known_idle & ~(1 << me)
      :: else
      fi;
#ifndef BUSY_IGNORED
      all_idle = all_idle && !working && waiting == 0;
#endif
      sum_sent = sum_sent + known_sent;
      sum_processed = sum_processed + known_processed
    }
  od
}

#define ALL ((1 << NODES) - 1)
#define WORTH (noticed && known_idle == ALL)

inline begin_wave() {
  in_wave = true;
  noticed = false;
  probe[0] = true;
  probe[1] = true;
  probe[2] = true
}

#ifdef NOTICE_FORGOTTEN
#define LATE noticed = noticed && !in_wave;
#else
#define LATE
#endif
#define HEAR(n)                       \
  :: d_step {                         \
      idle_notice[n] -> hear_notice(n); LATE \
      if                              \
      :: !in_wave && WORTH -> begin_wave() \
      :: else                         \
      fi                              \
    }

proctype coordinator() {
  byte had_sent;
  bool in_wave, had_sums, quiet, could_be_quiet;
  do
  HEAR(0)
  HEAR(1)
  HEAR(2)
  :: d_step {
      answers == NODES ->
      could_be_quiet = all_idle && sum_sent == sum_processed;
#ifdef ONE_WAVE
      quiet = could_be_quiet;
#else
      quiet = could_be_quiet && had_sums && had_sent == sum_sent;
#endif
      had_sums = could_be_quiet;
      had_sent = (could_be_quiet -> sum_sent : 0);
      answers = 0; sum_sent = 0; sum_processed = 0; all_idle = true; in_wave = false;
      if
      :: !quiet && (could_be_quiet || WORTH) -> begin_wave()
      :: else
      fi;
      could_be_quiet = false
    }
  :: quiet -> break
  od;
  assert(live == 0 && at_work == 0)  // quiet is believed: it is true. That it never is would be an invalid end state
}

init {
  atomic {
    all_idle = true;
    run tile(0); run tile(1); run tile(2);
    run part(0); run part(1); run part(2);
    run coordinator()
  }
}
