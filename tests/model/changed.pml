// What tiles know and note of each other while a stored result is changed and nodes are lost (docs/updates-design.md):
// src/tiling/tile/fresh_points.h, src/tiling/tile/introduce.cc, TileTriangulation::receive_changed(). As loss.pml, but
// old points are free knowledge: what stands in F_i is known without a message, also to a tile that begins again.
//
// Geometry is anything: a point that arrives becomes a vertex or is refused, and any vertices may be its neighbours. A
// point is old, affected (old and fresh) or new, and F_i is any set of old foreign points. One step is the work of one
// tile. Points, as tokens: TILES + EXTRA, token v of tile v, the others of the last tile. A slot is a point on its way.
// Mail to the dead is gone at once, mail from the dead when the tile that has it applies the table.
#define TILES 3
#ifndef EXTRA
#define EXTRA 0
#endif
#ifndef CRASHES
#define CRASHES 1
#endif
#ifndef FRESH  // fresh points at most
#define FRESH 3
#endif
#define TOKENS (TILES + EXTRA)
#define EPOCHS (CRASHES + 1)
#define SLOTS (TILES * EPOCHS * TOKENS * 2)  // by sender, its incarnation, point, and fresh bit
#define AT(me, v) ((me) * TOKENS + (v))
#define OWNER(v) ((v) - (v) / TILES * ((v) - TILES + 1))  // of the last tile, if there is no such tile
#define HAS(mask, x) (((mask) >> (x)) & 1)
#define INCARNATION(e, me) incarnation[(e) * TILES + (me)]
#define SLOT(to, from, i, v, b) slot[(to) * SLOTS + (((from) * EPOCHS + (i)) * TOKENS + (v)) * 2 + (b)]
#define PACK(e, words) (128 | ((e) << 4) | (words))
#define KNOWS(me, v) (OWNER(v) == (me) || HAS(vertices[me] | refused[me] | stored[me], v))
#define KNOWS_AS_FRESH(me, v) (HAS(fresh, v) && (OWNER(v) == (me) || HAS(known_fresh[me], v)))

// Coordinator
byte epoch;
byte incarnation[EPOCHS * TILES];  // by epoch
byte node[TILES];
byte alive = (1 << TILES) - 1;
byte crashes = CRASHES;
// The change, in masks of tokens: the same in each life
byte fresh, new;
byte stored[TILES];  // F_i
// Tiles, in masks of tokens
bool up[TILES];
bool awake[TILES];
byte applied[TILES];  // the table's epoch
byte vertices[TILES], refused[TILES];
byte known_fresh[TILES];  // foreign vertices and refused points
byte due[TILES];          // reborn tiles to replay to; 128: a new table
// Tiles, by token, in masks of tiles
byte sent[TILES * TOKENS];    // noted for whom: told, heard from, or relied on a word
byte relied[TILES * TOKENS];  // of these, for whom on somebody's word alone
byte word[TILES * TOKENS];    // who has been told, they say
byte quoted[TILES * TOKENS];  // to whom
// Ghosts, in masks of tokens: with whom this tile believes a fresh point introduced, by the fresh one; and new
// neighbours of a refused point that is not fresh.
byte introduced[TILES * TOKENS], introduced_refused[TILES * TOKENS];
byte slot[TILES * SLOTS];
byte ready;  // tiles that have mail to take

// Scratch of a step, 0 between two. Not `hidden`: what a d_step changes of that is not restored on the way back.
byte me, u, v, w, j, f, i, x, last, words, marked, neighbours, to;
byte out[TOKENS];
byte quiet, insert, again, from_itself;

inline note(vertex, tile) {
  sent[AT(me, vertex)] = sent[AT(me, vertex)] | (1 << (tile));
  word[AT(me, vertex)] = word[AT(me, vertex)] | (1 << (tile))
}

#define IS_KNOWN_BY(tile, vertex) (OWNER(vertex) == (tile) || HAS(sent[AT(me, vertex)], tile))

inline share(vertex, tile) {
  if
  :: (tile) == me || IS_KNOWN_BY(tile, vertex)
  :: else -> note(vertex, tile); out[vertex] = out[vertex] | (1 << (tile))
  fi
}

inline quote(vertex, tile) {
  if
  :: (tile) == me || IS_KNOWN_BY(tile, vertex) || HAS(quoted[AT(me, vertex)], tile)
  :: else ->
    printf("  quotes %d to %d\n", vertex, tile);
    quoted[AT(me, vertex)] = quoted[AT(me, vertex)] | (1 << (tile));
    out[vertex] = out[vertex] | (1 << (tile));
#ifdef QUOTES_NOTED
    note(vertex, tile)
#endif
  fi
}

inline rely(vertex, tile) {
  if
  :: HAS(sent[AT(me, vertex)], tile)
  :: else ->
    printf("  relies on it that %d has been told of %d\n", tile, vertex);
    sent[AT(me, vertex)] = sent[AT(me, vertex)] | (1 << (tile));
    relied[AT(me, vertex)] = relied[AT(me, vertex)] | (1 << (tile))
  fi
}

#define IS_FRESH(t) (OWNER(t) == me && HAS(fresh, t) || HAS(known_fresh[me], t))

// What arrived or became due, `v`, is an edge's end, and `u` the other.
inline introduce() {
  if
  :: OWNER(u) == OWNER(v) || (!IS_FRESH(v) && !IS_FRESH(u))
  :: else ->
    if
    :: IS_FRESH(v) -> introduced[AT(me, v)] = introduced[AT(me, v)] | (1 << u)
    :: else
    fi;
    if
    :: IS_FRESH(u) -> introduced[AT(me, u)] = introduced[AT(me, u)] | (1 << v)
    :: else
    fi;
    if
    :: OWNER(u) == me -> share(u, OWNER(v))
    :: OWNER(v) == me -> share(v, OWNER(u))
    :: else ->
      if
      :: IS_KNOWN_BY(OWNER(v), u) || IS_KNOWN_BY(OWNER(u), v)
      :: else ->
        if
        :: HAS(word[AT(me, u)], OWNER(v)) -> rely(u, OWNER(v))
        :: !HAS(word[AT(me, u)], OWNER(v)) && HAS(word[AT(me, v)], OWNER(u)) -> rely(v, OWNER(u))
        :: else ->
          if
          :: !IS_FRESH(u) -> quote(u, OWNER(v))
          :: IS_FRESH(u) && !IS_FRESH(v) -> quote(v, OWNER(u))
          :: else -> share(u, OWNER(v))
          fi
        fi
      fi
    fi
  fi
}

// The refused point `v`, which `f` has sent, and its would-be neighbour `u`.
inline introduce_refused() {
  if
  :: OWNER(u) == OWNER(v) || (!IS_FRESH(v) && !IS_FRESH(u))
  :: else ->
    if
    :: IS_FRESH(v) -> introduced[AT(me, v)] = introduced[AT(me, v)] | (1 << u)
    :: !IS_FRESH(v) && HAS(new, u) -> introduced_refused[AT(me, v)] = introduced_refused[AT(me, v)] | (1 << u)
    :: else
    fi;
#ifndef REFUSED_NOT_INTRODUCED
    from_itself = OWNER(u) == f && (marked || f == OWNER(v));
    if
    :: IS_KNOWN_BY(OWNER(v), u)
    :: !IS_KNOWN_BY(OWNER(v), u) && from_itself -> sent[AT(me, v)] = sent[AT(me, v)] | (1 << OWNER(u))
    :: !IS_KNOWN_BY(OWNER(v), u) && !from_itself && HAS(words, OWNER(u)) -> rely(v, OWNER(u))
    :: else ->
      if
      :: HAS(word[AT(me, u)], OWNER(v)) -> rely(u, OWNER(v))
      :: !HAS(word[AT(me, u)], OWNER(v)) && !IS_FRESH(v) -> quote(v, OWNER(u))
      :: !HAS(word[AT(me, u)], OWNER(v)) && IS_FRESH(v) && IS_FRESH(u) -> share(u, OWNER(v))
      :: else -> quote(u, OWNER(v))
      fi
    fi;
    from_itself = 0
#endif
  fi
}

// What has become due is on its way, with the bit as it is known by now; nothing of this step stays behind.
inline finish_step() {
  for (u : 0 .. TOKENS - 1) {
    for (j : 0 .. TILES - 1) {
      if
      :: HAS(out[u], j) && INCARNATION(applied[me], j) == INCARNATION(epoch, j) ->
        marked = IS_FRESH(u);
#ifdef BIT_NOT_REPLAYED
        marked = marked && (!again || OWNER(u) == me);
#endif
        printf("  tells %d of %d, told: %d, fresh: %d\n", j, u, word[AT(me, u)], marked);
        if  // two that say the same are one
        :: SLOT(j, me, INCARNATION(epoch, me), u, marked) == 0 ->
          SLOT(j, me, INCARNATION(epoch, me), u, marked) = PACK(applied[me], word[AT(me, u)])
        :: else
        fi
      :: else
      fi
    }
    out[u] = 0
  }
  check_quiet()
}

inline check_quiet() {
  quiet = true;
  for (i : 0 .. TILES - 1) {
    quiet = quiet && up[i] && applied[i] == epoch && due[i] == 0
  }
  if
  :: quiet ->
    for (x : 0 .. TILES * SLOTS - 1) {
      quiet = quiet && slot[x] == 0
    }
  :: else
  fi;
  if
  :: quiet ->
    for (i : 0 .. TILES - 1) {
      for (u : 0 .. TOKENS - 1) {
        for (j : 0 .. TILES - 1) {
          assert(!HAS(sent[AT(i, u)], j) || KNOWS(j, u));  // noted is known
          assert(!HAS(sent[AT(i, u)], j) || !HAS(fresh, u) || KNOWS_AS_FRESH(j, u))  // and known to be fresh
        }
        for (w : 0 .. TOKENS - 1) {
          if
          :: HAS(introduced[AT(i, u)], w) ->
            assert(OWNER(u) != i || KNOWS_AS_FRESH(OWNER(w), u));                                      // R1
            assert(OWNER(u) == i || OWNER(w) != i || KNOWS(OWNER(u), w));                              // R2
            assert(KNOWS_AS_FRESH(OWNER(w), u) || KNOWS(OWNER(u), w))                                  // R3, R4
          :: else
          fi;
          assert(!HAS(introduced_refused[AT(i, u)], w) || KNOWS(OWNER(u), w) || KNOWS(OWNER(w), u))    // R4
        }
      }
    }
  :: else
  fi
}

#define OWN(t) ((1 << (t)) | ((t) == TILES - 1 -> ((1 << TOKENS) - (1 << TILES)) : 0))

// All stored points are there before anything else: when a tile begins, and when it is woken.
inline build() {
  awake[me] = true;
  vertices[me] = OWN(me) | stored[me]
}

// A tile without fresh points of its own sleeps. Any of the others' first edges may be.
inline begin() {
  d_step {
    up[me] = true;
    applied[me] = epoch;
    printf("tile %d.%d begins\n", me, INCARNATION(epoch, me));
    drop_dead_mail();
    if
    :: (OWN(me) & fresh) != 0 -> build()
    :: else
    fi
  }
  if
  :: awake[me] ->
    v = 0;
    do
    :: v < TOKENS && OWNER(v) == me && HAS(fresh, v) ->
      u = 0;
      do
      :: u < TOKENS && HAS(stored[me], u) -> d_step { introduce(); u++ }
      :: u < TOKENS -> u++
      :: u == TOKENS -> break
      od;
      v++
    :: v < TOKENS && !(OWNER(v) == me && HAS(fresh, v)) -> v++
    :: v == TOKENS -> break
    od
  :: else
  fi;
  skip;  // a loop must not end where a d_step begins
  d_step { finish_step() }
}

inline drop_dead_mail() {
  for (j : 0 .. TILES - 1) {
    for (i : 1 .. INCARNATION(applied[me], j)) {
      for (u : 0 .. TOKENS - 1) {
        SLOT(me, j, i - 1, u, 0) = 0;
        SLOT(me, j, i - 1, u, 1) = 0
      }
    }
  }
}

inline apply_table() {
  d_step {
    applied[me]++;
    printf("tile %d gets table %d\n", me, applied[me]);
    due[me] = due[me] | 128;
    for (j : 0 .. TILES - 1) {
      if
      :: INCARNATION(applied[me], j) != INCARNATION(applied[me] - 1, j) -> due[me] = due[me] | (1 << j)
      :: else
      fi
    }
    drop_dead_mail();
    check_quiet()
  }
}

inline replay() {
  d_step {
    printf("tile %d replays\n", me);
    for (u : 0 .. TOKENS - 1) {
#ifndef NO_REPLAY
      out[u] = sent[AT(me, u)] & due[me] & ~(1 << OWNER(u));
      relied[AT(me, u)] = relied[AT(me, u)] & ~due[me];
#endif
#ifndef QUOTES_NOT_REPLAYED
      out[u] = out[u] | (quoted[AT(me, u)] & due[me]);
#endif
#ifndef NO_RETELL
      out[u] = out[u] | relied[AT(me, u)];
      relied[AT(me, u)] = 0;
#endif
      word[AT(me, u)] = (HAS(vertices[me], u) -> sent[AT(me, u)] : 0)
    }
    due[me] = 0;
    again = true;
    finish_step()
  }
}

#define TAKEABLE(me, x) (slot[(me) * SLOTS + (x)] != 0 && ((slot[(me) * SLOTS + (x)] >> 4) & 7) <= applied[me])

inline take() {
  d_step {
    for (x : 0 .. SLOTS - 1) {
      if
      :: TAKEABLE(me, x) -> last = x
      :: else
      fi
    }
    x = 0
  }
  do
  :: x < last -> x++
  :: TAKEABLE(me, x) -> break
  od;
  skip;  // a loop must not end where a d_step begins
  d_step {
    f = x / (EPOCHS * TOKENS * 2);
    v = (x / 2) % TOKENS;
    marked = x % 2;
    words = slot[me * SLOTS + x] & 15;
    if
    :: ((slot[me * SLOTS + x] >> 4) & 7) < applied[me] -> words = 0
    :: else
    fi;
    slot[me * SLOTS + x] = 0;
    neighbours = 0;
    if
    :: awake[me]
    :: else -> build()
    fi;
    printf("tile %d is told of %d by %d, words %d, fresh: %d\n", me, v, f, words, marked)
  }
  if
  :: HAS(vertices[me], v) -> insert = 1
  :: HAS(refused[me], v) -> insert = 0
  :: else ->
    if
    :: insert = 2  // as a new vertex
    :: (vertices[me] & ~OWN(me)) != 0 -> insert = 3  // newly refused: some vertex is foreign
    fi
  fi;
  // A vertex that arrives has a local neighbour, and a refused one has none.
  if
  :: insert >= 2 || (marked && !HAS(known_fresh[me], v)) ->
    u = 0;
    do
    :: u < TOKENS && u != v && HAS(vertices[me], u) && ((insert == 1 || insert == 2) || OWNER(u) != me) ->
      neighbours = neighbours | (1 << u); u++
    :: u < TOKENS && (insert != 2 || u != me) -> u++
    :: u == TOKENS -> break
    od
  :: else
  fi;
  skip;
  d_step {
    if
    :: insert == 2 -> printf("  inserts it beside the points %d\n", neighbours); vertices[me] = vertices[me] | (1 << v)
    :: insert == 3 -> printf("  refuses it beside the points %d\n", neighbours); refused[me] = refused[me] | (1 << v)
    :: else -> printf("  knows it, beside the points %d\n", neighbours)
    fi;
    if
#ifdef KNOWN_IS_NO_NEWS
    :: marked && insert == 1
#endif
    :: marked -> known_fresh[me] = known_fresh[me] | (1 << v)
    :: else
    fi;
    if
    :: HAS(vertices[me], v) ->
      word[AT(me, v)] = word[AT(me, v)] | words;
      if
      :: marked || f == OWNER(v) -> note(v, f)
      :: else  // a quote
      fi
    :: else
    fi;
    for (u : 0 .. TOKENS - 1) {
      if
      :: !HAS(neighbours, u)
      :: HAS(neighbours, u) && (insert == 1 || insert == 2) -> introduce()
      :: else -> introduce_refused()
      fi
    }
  }
  d_step { finish_step() }
}

inline lose(dead) {
  d_step {
    crashes--;
    printf("node %d is lost\n", dead);
    alive = alive & ~(1 << (dead));
    for (j : 0 .. TILES - 1) {
      INCARNATION(epoch + 1, j) = INCARNATION(epoch, j)
    }
    epoch++;
    to = 0;
    do
    :: !HAS(alive, to) -> to++
    :: else -> break
    od;
    for (j : 0 .. TILES - 1) {
      if
      :: node[j] == (dead) ->
        node[j] = to;
        INCARNATION(epoch, j) = INCARNATION(epoch, j) + 1;
        up[j] = false; awake[j] = false; applied[j] = 0; vertices[j] = 0; refused[j] = 0; known_fresh[j] = 0; due[j] = 0;
        for (u : 0 .. TOKENS - 1) {
          sent[AT(j, u)] = 0; relied[AT(j, u)] = 0; word[AT(j, u)] = 0; quoted[AT(j, u)] = 0;
          introduced[AT(j, u)] = 0; introduced_refused[AT(j, u)] = 0
        }
        for (x : 0 .. SLOTS - 1) {
          slot[j * SLOTS + x] = 0
        }
      :: else
      fi
    }
  }
}

// In every way.
inline choose_change() {
  to = FRESH;
  for (v : 0 .. TOKENS - 1) {
    if
    :: skip  // old, and not affected
    :: to > 0 -> fresh = fresh | (1 << v); to--  // affected
    :: to > 0 -> fresh = fresh | (1 << v); new = new | (1 << v); to--
    fi
  }
  for (j : 0 .. TILES - 1) {
    for (v : 0 .. TOKENS - 1) {
      if
      :: skip
      :: OWNER(v) != j && !HAS(new, v) -> stored[j] = stored[j] | (1 << v)
      fi
    }
  }
}

// Every step ends with it: what is scratch is forgotten.
inline reset() {
  d_step {
    ready = 0;
    for (me : 0 .. TILES - 1) {
      for (x : 0 .. SLOTS - 1) {
        if
        :: up[me] && due[me] == 0 && TAKEABLE(me, x) -> ready = ready | (1 << me); break
        :: else
        fi
      }
    }
    me = 0; u = 0; v = 0; j = 0; i = 0; x = 0; w = 0; f = 0; last = 0; to = 0; words = 0; marked = 0; neighbours = 0;
    insert = 0; again = 0; from_itself = 0; quiet = 0
  }
}

active proctype system() {
  atomic {
    for (j : 0 .. TILES - 1) {
      node[j] = j
    }
    choose_change();
    reset()
  }
  do
#define STEPS(k)                                                              \
  :: atomic { !up[k] -> me = k; begin(); reset() }                            \
  :: atomic { up[k] && applied[k] < epoch -> me = k; apply_table(); reset() } \
  :: atomic { up[k] && due[k] != 0 -> me = k; replay(); reset() }             \
  :: atomic { HAS(ready, k) -> me = k; take(); reset() }
  STEPS(0)
  STEPS(1)
  STEPS(2)
#define CRASH(k) :: atomic { crashes > 0 && HAS(alive, k) && alive != (1 << (k)) -> lose(k); reset() }
  CRASH(0)
  CRASH(1)
  CRASH(2)
  :: else -> d_step { check_quiet(); assert(quiet); reset() } break
  od
}
