// Quiescence and the end of a job while nodes are lost (docs/cluster-design.md): tables, waves, counters, settled files, entries.
// A tile a node at first. Batches say nothing, and those of one pair of incarnations look alike: they are numbers.
#define TILES 3
#ifndef CRASHES
#define CRASHES 1
#endif
#ifndef BATCHES  // sent at most, beside replays
#define BATCHES 2
#endif
#define EPOCHS (CRASHES + 1)
#define HAS(mask, x) (((mask) >> (x)) & 1)
#define LIVE(e, k) incarnation[(e) * TILES + (k)]
#define END(k, i) ((k) * EPOCHS + (i))  // a tile's incarnation
#define PAIR(me, other, i) ((me) * TILES * EPOCHS + END(other, i))
#define TALLY(e, k) ((e) * TILES + (k))

mtype = { exchanging, settling, collecting, finished };

// Coordinator
mtype state = exchanging;
byte epoch, incarnation[EPOCHS * TILES], node[TILES], crashes = CRASHES;
byte alive = (1 << TILES) - 1;
byte known_idle;      // nodes
bool noticed = true;  // since the last wave began: one has said that it is idle, or there is a new epoch
bool in_wave, had_sums, all_idle = true;
byte had_sent, answered, sum_sent, sum_processed;
byte said_settled;  // by node
byte entry[TILES];  // 1 + the incarnation that is stored
byte quiet_at;      // ghost: 1 + the epoch in which quiet was believed last
// Messages between coordinator and parts, by epoch and node
byte asked[EPOCHS], told_to_settle[EPOCHS];
bool answer[EPOCHS * TILES], idle[EPOCHS * TILES], settled_said[EPOCHS * TILES];
byte answer_sent[EPOCHS * TILES], answer_processed[EPOCHS * TILES];
byte told_idle, idle_notice;  // nodes: since the last answer or table; it is under way
// Tiles
bool up[TILES], due[TILES];
byte applied[TILES], reborn[TILES];
byte budget = BATCHES;
byte flight[TILES * EPOCHS * TILES * EPOCHS];  // by sender and receiver
byte sent[TILES * TILES * EPOCHS], processed[TILES * TILES * EPOCHS];  // of a tile, by the other end
byte file[TILES];  // 1 + the epoch in which it was written

byte waits;  // tiles that mail has reached
// Scratch of a step, 0 between two.
byte me, other, i, k, x, last;
bool quiet;

#define FLIGHT(from, fi, to, ti) flight[END(from, fi) * TILES * EPOCHS + END(to, ti)]

inline send_to(peer) {
  FLIGHT(me, LIVE(epoch, me), peer, LIVE(applied[me], peer))++;
  sent[PAIR(me, peer, LIVE(applied[me], peer))]++
}

inline send_some() {
  do
  :: budget > 0 -> budget--; send_to((me + 1) % TILES)
  :: budget > 0 -> budget--; send_to((me + 2) % TILES)
  :: break
  od;
  say_if_idle()
}

// The part of this tile's node, after each step. What it goes by may be an older table than the coordinator's.
inline say_if_idle() {
  d_step {
    quiet = !HAS(told_idle, node[me]);
    for (k : 0 .. TILES - 1) {
      quiet = quiet && (node[k] != node[me] || (up[k] && applied[k] == applied[me] && !due[k]))
    }
    if
    :: quiet -> told_idle = told_idle | (1 << node[me]); idle_notice = idle_notice | (1 << node[me])
    :: else
    fi;
    quiet = false;
    k = 0
  }
}

// What a node says comes in its order: a notice before an answer, if it was said before.
#if EPOCHS == 1
#define ANSWERS(t) answer[TALLY(0, t)]
#elif EPOCHS == 2
#define ANSWERS(t) (answer[TALLY(0, t)] || answer[TALLY(1, t)])
#else
#define ANSWERS(t) (answer[TALLY(0, t)] || answer[TALLY(1, t)] || answer[TALLY(2, t)])
#endif
inline hear_notice(n) {
  idle_notice = idle_notice & ~(1 << (n));
  if
  :: state == exchanging && HAS(alive, n) -> known_idle = known_idle | (1 << (n)); noticed = true
  :: else
  fi
}

// A new table has come: it says anew when it is idle.
inline forget_idle() { told_idle = told_idle & ~(1 << node[me]) }

inline begin() { forget_idle(); up[me] = true; applied[me] = epoch; send_some() }

inline apply_table() {
  d_step {
    applied[me]++;
    due[me] = true;
    forget_idle();
    for (k : 0 .. TILES - 1) {
      if
      :: LIVE(applied[me], k) != LIVE(applied[me] - 1, k) ->
        reborn[me] = reborn[me] | (1 << k);
#ifndef COUNTERS_NOT_BY_INCARNATION
        for (i : 1 .. LIVE(applied[me], k)) {
          sent[PAIR(me, k, i - 1)] = 0;
          processed[PAIR(me, k, i - 1)] = 0
        }
#endif
      :: else
      fi
    }
  }
}

inline replay() {
  due[me] = false;
  for (k : 0 .. TILES - 1) {
    if
    :: HAS(reborn[me], k) -> send_to(k)
    :: true
    fi
  }
  reborn[me] = 0;
  say_if_idle()
}

// Any batch that has reached the tile; `to` of it is its own incarnation, or was a dead one's.
inline find_mail() {
  d_step {
    last = 255;
    for (x : 0 .. TILES * EPOCHS * EPOCHS - 1) {
      if
      :: flight[(x / EPOCHS) * TILES * EPOCHS + END(me, x % EPOCHS)] > 0 -> last = x
      :: else
      fi
    }
    x = 0
  }
}

inline take() {
  do
  :: x < last -> x++
  :: flight[(x / EPOCHS) * TILES * EPOCHS + END(me, x % EPOCHS)] > 0 -> break
  od;
  skip;
  d_step {
    flight[(x / EPOCHS) * TILES * EPOCHS + END(me, x % EPOCHS)]--;
    other = x / EPOCHS / EPOCHS;
    i = (x / EPOCHS) % EPOCHS
  }
  if
#ifndef NO_INCARNATION_CHECK
  :: x % EPOCHS != LIVE(epoch, me)
#endif
#ifndef KEEP_DEAD_MAIL
  :: i < LIVE(applied[me], other)
#endif
  :: else -> processed[PAIR(me, other, i)]++; send_some()
  fi
}

// Of a part: a snapshot of its tiles. `e`: of the wave, whose table has come before.
inline reply(e) {
  d_step {
    asked[e] = asked[e] & ~(1 << me);
    if
    :: HAS(idle_notice, me) -> hear_notice(me)
    :: else
    fi;
#ifndef SILENT_AFTER_ANSWER
    told_idle = told_idle & ~(1 << me);
#endif
    answer[TALLY(e, me)] = true;
    idle[TALLY(e, me)] = true;
    for (k : 0 .. TILES - 1) {
      if
      :: node[k] == me ->
#ifndef TABLE_NOT_AWAITED
        idle[TALLY(e, me)] = idle[TALLY(e, me)] && up[k] && applied[k] == e && !due[k];
#else
        idle[TALLY(e, me)] = idle[TALLY(e, me)] && !due[k];
#endif
        for (i : 0 .. TILES * EPOCHS - 1) {
          answer_sent[TALLY(e, me)] = answer_sent[TALLY(e, me)] + sent[k * TILES * EPOCHS + i];
          answer_processed[TALLY(e, me)] = answer_processed[TALLY(e, me)] + processed[k * TILES * EPOCHS + i]
        }
      :: else
      fi
    }
  }
}

#define WORTH (noticed && known_idle == alive)
inline begin_wave() { in_wave = true; noticed = false; asked[epoch] = alive; answered = 0 }

inline hear(e) {
  d_step {
    answer[TALLY(e, me)] = false;
    if
#ifndef TALLY_WITHOUT_EPOCH
    :: in_wave && e == epoch && !HAS(answered, me) ->
#else
    :: in_wave && !HAS(answered, me) && HAS(alive, me) ->
#endif
      answered = answered | (1 << me);
      all_idle = all_idle && idle[TALLY(e, me)];
      known_idle = (idle[TALLY(e, me)] -> known_idle : known_idle & ~(1 << me));
      sum_sent = sum_sent + answer_sent[TALLY(e, me)];
      sum_processed = sum_processed + answer_processed[TALLY(e, me)]
    :: else
    fi;
    idle[TALLY(e, me)] = false; answer_sent[TALLY(e, me)] = 0; answer_processed[TALLY(e, me)] = 0
  }
}

inline judge() {
  d_step {
    quiet = all_idle && sum_sent == sum_processed;
    in_wave = false;
    if
#ifdef ONE_WAVE
    :: quiet -> believe()
#else
    :: quiet && had_sums && had_sent == sum_sent -> believe()
#endif
    :: quiet && !(had_sums && had_sent == sum_sent) -> had_sums = true; had_sent = sum_sent; begin_wave()
    :: !quiet -> had_sums = false; had_sent = 0
    fi;
    all_idle = true; sum_sent = 0; sum_processed = 0; answered = 0; quiet = false
  }
}

inline believe() {
  for (k : 0 .. TILES - 1) {
    assert(up[k] && applied[k] == epoch && !due[k]);  // all tables are applied
    for (x : 0 .. TILES * EPOCHS - 1) {
      // no batch between the living is under way
      assert(x % EPOCHS != LIVE(epoch, x / EPOCHS) || flight[x * TILES * EPOCHS + END(k, LIVE(epoch, k))] == 0)
    }
  }
  state = settling;
  quiet_at = epoch + 1;
  told_to_settle[epoch] = alive
}

inline settle(e) {
  d_step {
    told_to_settle[e] = told_to_settle[e] & ~(1 << me);
    settled_said[TALLY(e, me)] = true;
    for (k : 0 .. TILES - 1) {
      if
      :: node[k] == me && up[k] && applied[k] == e -> file[k] = e + 1  // Settle of an earlier table is ignored
      :: else
      fi
    }
  }
}

inline hear_settled(e) {
  d_step {
    settled_said[TALLY(e, me)] = false;
    if
#ifndef SETTLED_TOO_EARLY
    :: state == settling && e == epoch -> said_settled = said_settled | (1 << me)
#else
    :: state == settling -> said_settled = alive  // the first is believed for all
#endif
    :: else
    fi
  }
}

inline lose(dead) {
  d_step {
    crashes--;
    alive = alive & ~(1 << (dead));
    for (k : 0 .. TILES - 1) {
      LIVE(epoch + 1, k) = LIVE(epoch, k)
    }
    epoch++;
    other = 0;
    do
    :: !HAS(alive, other) -> other++
    :: else -> break
    od;
    for (k : 0 .. TILES - 1) {
      if
      :: node[k] == (dead) ->
        node[k] = other;
        LIVE(epoch, k) = LIVE(epoch, k) + 1;
        entry[k] = 0;  // not of this table's incarnation
        up[k] = false; applied[k] = 0; due[k] = false; reborn[k] = 0;
        if
        :: state != collecting -> file[k] = 0  // it may not be synced
        :: else
        fi;
        for (i : 0 .. TILES * EPOCHS - 1) {
          sent[k * TILES * EPOCHS + i] = 0;
          processed[k * TILES * EPOCHS + i] = 0
        }
      :: else
      fi
    }
    for (k : 0 .. epoch) {
      asked[k] = asked[k] & ~(1 << (dead));
      told_to_settle[k] = told_to_settle[k] & ~(1 << (dead))
    }
    told_idle = told_idle & ~(1 << (dead)); idle_notice = idle_notice & ~(1 << (dead));
    if
    :: state != collecting ->
      state = exchanging; in_wave = false; answered = 0; all_idle = true; sum_sent = 0; sum_processed = 0;
      had_sums = false; had_sent = 0; said_settled = 0;
      known_idle = 0; noticed = true
    :: else
    fi
  }
}

inline store() {
  assert(file[me] != 0 && file[me] == quiet_at);  // made of what was written when all was quiet
  entry[me] = LIVE(epoch, me) + 1
}

inline reset() {
  d_step {
    waits = 0;
    for (me : 0 .. TILES - 1) {
      for (x : 0 .. TILES * EPOCHS * EPOCHS - 1) {
        if
        :: flight[(x / EPOCHS) * TILES * EPOCHS + END(me, x % EPOCHS)] > 0 -> waits = waits | (1 << me)
        :: else
        fi
      }
    }
    me = 0; other = 0; i = 0; k = 0; x = 0; last = 0
  }
}

#define EXCHANGES (state == exchanging || state == settling)
// A probe of an earlier epoch is under way to this node: its table comes after that.
#if EPOCHS == 1
#define ASKED_BEFORE(n, e) false
#elif EPOCHS == 2
#define ASKED_BEFORE(n, e) ((e) > 0 && HAS(asked[0], n))
#else
#define ASKED_BEFORE(n, e) (((e) > 0 && HAS(asked[0], n)) || ((e) > 1 && HAS(asked[1], n)))
#endif
#define STEPS(t)                                                                                                                     \
  :: atomic { EXCHANGES && !up[t] && !ASKED_BEFORE(node[t], epoch) -> me = t; begin(); reset() }                                     \
  :: atomic { EXCHANGES && up[t] && applied[t] < epoch && !ASKED_BEFORE(node[t], applied[t] + 1) -> me = t; apply_table(); reset() } \
  :: atomic { EXCHANGES && due[t] -> me = t; replay(); reset() }                                                                     \
  :: atomic { EXCHANGES && up[t] && !due[t] && HAS(waits, t) -> me = t; find_mail(); take(); reset() }                               \
  :: atomic { state == exchanging && WORTH && !in_wave -> begin_wave(); reset() }                                                    \
  :: atomic { state == collecting && entry[t] == 0 -> me = t; store(); reset() }                                                     \
  :: atomic { state != finished && crashes > 0 && HAS(alive, t) && alive != (1 << (t)) -> lose(t); reset() }
#define NOTICE(t) :: atomic { HAS(idle_notice, t) && !ANSWERS(t) -> hear_notice(t) }
#define CONTROL(t, e)                                                                \
  :: atomic { HAS(asked[e], t) && !ASKED_BEFORE(t, e) -> me = t; reply(e); reset() } \
  :: atomic { answer[TALLY(e, t)] -> me = t; hear(e); reset() }                      \
  :: atomic { HAS(told_to_settle[e], t) -> me = t; settle(e); reset() }              \
  :: atomic { settled_said[TALLY(e, t)] -> me = t; hear_settled(e); reset() }

active proctype system() {
  atomic {
    for (k : 0 .. TILES - 1) {
      node[k] = k
    }
    reset()
  }
  do
  STEPS(0)
  STEPS(1)
  STEPS(2)
  NOTICE(0)
  NOTICE(1)
  NOTICE(2)
  CONTROL(0, 0)
  CONTROL(1, 0)
  CONTROL(2, 0)
#if EPOCHS > 1
  CONTROL(0, 1)
  CONTROL(1, 1)
  CONTROL(2, 1)
#endif
#if EPOCHS > 2
  CONTROL(0, 2)
  CONTROL(1, 2)
  CONTROL(2, 2)
#endif
  :: atomic { in_wave && answered == alive -> judge(); reset() }
  :: atomic { state == settling && said_settled == alive -> state = collecting; said_settled = 0 }
  :: atomic {
      state == collecting && entry[0] != 0 && entry[1] != 0 && entry[2] != 0 ->
      for (k : 0 .. TILES - 1) {
        assert(entry[k] == LIVE(epoch, k) + 1)  // of the living incarnation
      }
      state = finished; k = 0
    }
  :: else -> assert(state == finished); break  // whatever was lost, it ends
  od
}
