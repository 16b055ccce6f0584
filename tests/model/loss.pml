// What tiles know and note of each other while nodes are lost (docs/cluster-design.md). One step is the work of one tile.
//
// Geometry is anything: a point that arrives becomes a vertex or is refused, and any vertices may be its neighbours.
// Points, as tokens: TILES + EXTRA, token v of tile v, the others of the last tile. A slot is a point on its way.
// Mail to the dead is gone at once, mail from the dead when the tile that has it applies the table.
#ifndef TILES
#define TILES 3
#endif
#ifndef EXTRA
#define EXTRA 0
#endif
#ifndef CRASHES
#define CRASHES 1
#endif
#ifndef ANNOUNCED  // points announced at most, of all tiles together
#define ANNOUNCED 2
#endif
#ifndef NODES
#define NODES 3
#endif
#define TOKENS (TILES + EXTRA)
#define EPOCHS (CRASHES + 1)
#define SLOTS (TILES * EPOCHS * TOKENS)  // by sender, its incarnation, and point
#define AT(me, v) ((me) * TOKENS + (v))
#define OWNER(v) ((v) - (v) / TILES * ((v) - TILES + 1))  // of the last tile, if there is no such tile
#define HAS(mask, x) (((mask) >> (x)) & 1)
#define INCARNATION(e, me) incarnation[(e) * TILES + (me)]
#define SLOT(to, from, i, v) slot[(to) * SLOTS + ((from) * EPOCHS + (i)) * TOKENS + (v)]
#define PACK(e, words) (128 | ((e) << 4) | (words))
#define KNOWS(me, v) (OWNER(v) == (me) || HAS(vertices[me] | refused[me], v))

// Coordinator
byte epoch;
byte incarnation[EPOCHS * TILES];  // by epoch
byte node[TILES];
byte alive = (1 << NODES) - 1;
byte crashes = CRASHES;
// Tiles, in masks of tokens
bool up[TILES];
byte applied[TILES];  // the table's epoch
byte vertices[TILES], refused[TILES];
byte due[TILES];  // reborn tiles to replay to; 128: a new table
// Tiles, by token, in masks of tiles
byte announced[TILES * TOKENS];
byte sent[TILES * TOKENS];        // noted for whom: told, heard from, or relied on a word
byte relied[TILES * TOKENS];      // of these, for whom on somebody's word alone
byte word[TILES * TOKENS];        // who has been told, they say
byte introduced[TILES * TOKENS];  // ghost, in masks of tokens: with whom this tile believes it introduced
byte slot[TILES * SLOTS];
byte ready;  // tiles that have mail to take

// Scratch of a step, 0 between two. Not `hidden`: what a d_step changes of that is not restored on the way back.
byte me, u, v, w, j, f, i, x, last, words, neighbours, to;
byte out[TOKENS];
byte quiet, insert;

inline note(vertex, tile) {
  sent[AT(me, vertex)] = sent[AT(me, vertex)] | (1 << (tile));
  word[AT(me, vertex)] = word[AT(me, vertex)] | (1 << (tile));
}

inline share(vertex, tile) {
  if
  :: (tile) == me || OWNER(vertex) == (tile) || HAS(sent[AT(me, vertex)], tile)
  :: else -> note(vertex, tile); out[vertex] = out[vertex] | (1 << (tile))
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

// As src/tiling/tile/introduce.cc: what arrived, `v`, and its neighbour `u`.
inline introduce() {
  introduced[AT(me, v)] = introduced[AT(me, v)] | (1 << u);
  if
  :: OWNER(u) == OWNER(v)
  :: OWNER(u) != OWNER(v) && insert && OWNER(u) == me -> share(u, OWNER(v))
  :: OWNER(u) != OWNER(v) && insert && OWNER(u) != me ->
    if
    :: HAS(sent[AT(me, u)], OWNER(v)) || HAS(sent[AT(me, v)], OWNER(u))
    :: else ->
      if
      :: HAS(word[AT(me, u)], OWNER(v)) -> rely(u, OWNER(v))
      :: !HAS(word[AT(me, u)], OWNER(v)) && HAS(word[AT(me, v)], OWNER(u)) -> rely(v, OWNER(u))
      :: else -> share(u, OWNER(v))
      fi
    fi
  :: OWNER(u) != OWNER(v) && !insert ->
    if
    :: OWNER(u) == f ->
#ifndef REFUSED_NOT_NOTED
      sent[AT(me, v)] = sent[AT(me, v)] | (1 << OWNER(u))
#else
      skip
#endif
    :: OWNER(u) != f && HAS(words, OWNER(u)) ->
#ifndef REFUSED_NOT_NOTED
      rely(v, OWNER(u))
#else
      skip
#endif
    :: else ->
      if
      :: HAS(sent[AT(me, u)], OWNER(v))
      :: !HAS(sent[AT(me, u)], OWNER(v)) && HAS(word[AT(me, u)], OWNER(v)) -> rely(u, OWNER(v))
      :: else -> share(u, OWNER(v))
      fi
    fi
  fi
}

// What has become due is on its way; nothing of this step stays behind.
inline finish_step() {
  for (u : 0 .. TOKENS - 1) {
    for (j : 0 .. TILES - 1) {
      if
      :: HAS(out[u], j) && INCARNATION(applied[me], j) == INCARNATION(epoch, j) ->
        assert(SLOT(j, me, INCARNATION(epoch, me), u) == 0);
        printf("  tells %d of %d, told: %d\n", j, u, word[AT(me, u)]);
        SLOT(j, me, INCARNATION(epoch, me), u) = PACK(applied[me], word[AT(me, u)])
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
#ifdef PAIRS_ONLY
          skip
#else
          assert(!HAS(sent[AT(i, u)], j) || KNOWS(j, u))  // noted is known
#endif
        }
        for (w : 0 .. TOKENS - 1) {
          assert(!HAS(introduced[AT(i, u)], w) || KNOWS(OWNER(u), w) || KNOWS(OWNER(w), u))  // introduced is true
        }
      }
    }
  :: else
  fi
}

inline begin() {
  d_step {
    up[me] = true;
    applied[me] = epoch;
    printf("tile %d.%d begins\n", me, INCARNATION(epoch, me));
#ifndef KEEP_DEAD_MAIL
    for (j : 0 .. TILES - 1) {
      for (i : 1 .. INCARNATION(epoch, j)) {
        for (u : 0 .. TOKENS - 1) {
          SLOT(me, j, i - 1, u) = 0
        }
      }
    }
#endif
    for (u : 0 .. TOKENS - 1) {
      if
      :: OWNER(u) == me ->
        vertices[me] = vertices[me] | (1 << u);
        for (j : 0 .. TILES - 1) {
          if
          :: HAS(announced[AT(me, u)], j) -> share(u, j)
          :: else
          fi
        }
      :: else
      fi
    }
    finish_step()
  }
}

inline apply_table() {
  d_step {
    applied[me]++;
    printf("tile %d gets table %d\n", me, applied[me]);
    due[me] = due[me] | 128;
    for (j : 0 .. TILES - 1) {
      if
      :: INCARNATION(applied[me], j) != INCARNATION(applied[me] - 1, j) ->
        due[me] = due[me] | (1 << j);
#ifndef KEEP_DEAD_MAIL
        for (i : 1 .. INCARNATION(applied[me], j)) {
          for (u : 0 .. TOKENS - 1) {
            SLOT(me, j, i - 1, u) = 0
          }
        }
#endif
      :: else
      fi
    }
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
#ifndef NO_RETELL
      out[u] = out[u] | relied[AT(me, u)];
      relied[AT(me, u)] = 0;
#endif
#ifndef KEEP_WORDS
      word[AT(me, u)] = (HAS(vertices[me], u) -> sent[AT(me, u)] : 0)
#endif
    }
    due[me] = 0;
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
    f = x / (EPOCHS * TOKENS);
    v = x % TOKENS;
    words = slot[me * SLOTS + x] & 15;
#ifndef OLD_WORDS
    if
    :: ((slot[me * SLOTS + x] >> 4) & 7) < applied[me] -> words = 0
    :: else
    fi;
#endif
    slot[me * SLOTS + x] = 0;
    neighbours = 0;
    printf("tile %d is told of %d by %d, words %d\n", me, v, f, words)
  }
  if
  :: HAS(vertices[me], v) -> note(v, f); word[AT(me, v)] = word[AT(me, v)] | words
  :: HAS(refused[me], v)
  :: else ->
    if
    :: insert = true
    :: (vertices[me] & ~(1 << me) & ((1 << TILES) - 1)) != 0 -> insert = false  // some vertex is foreign
    fi;
    u = 0;
    do
    :: u < TOKENS && HAS(vertices[me], u) && (insert || OWNER(u) != me) -> neighbours = neighbours | (1 << u); u++
    :: u < TOKENS && (!insert || u != me) -> u++  // an inserted one has a local neighbour
    :: u == TOKENS -> break
    od;
    skip;
    d_step {
      if
      :: insert ->
        printf("  inserts it beside the points %d\n", neighbours);
        vertices[me] = vertices[me] | (1 << v);
        note(v, f);
        word[AT(me, v)] = word[AT(me, v)] | words
      :: else ->
        printf("  refuses it beside the points %d\n", neighbours);
        refused[me] = refused[me] | (1 << v)
      fi;
      for (u : 0 .. TOKENS - 1) {
        if
        :: HAS(neighbours, u) && u != v -> introduce()
        :: else
        fi
      }
    }
  fi;
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
        up[j] = false; applied[j] = 0; vertices[j] = 0; refused[j] = 0; due[j] = 0;
        for (u : 0 .. TOKENS - 1) {
          sent[AT(j, u)] = 0; relied[AT(j, u)] = 0; word[AT(j, u)] = 0; introduced[AT(j, u)] = 0
        }
        for (x : 0 .. SLOTS - 1) {
          slot[j * SLOTS + x] = 0
        }
      :: else
      fi
    }
  }
}

// Chosen in every way, or one way in which a mutant must fail.
inline choose_announced() {
#if SCENE == 1
  announced[AT(2, 2)] = 2;
  announced[AT(2, 3)] = 1
#elif SCENE == 2
  announced[AT(1, 1)] = 1;
  announced[AT(2, 2)] = 2;
  announced[AT(3, 3)] = 5
#elif SCENE == 3
  announced[AT(1, 1)] = 1;
  announced[AT(2, 2)] = 2;
  announced[AT(2, 3)] = 1
#else
  to = ANNOUNCED;
  for (v : 0 .. TOKENS - 1) {
    for (j : 0 .. TILES - 1) {
      if
      :: to > 0 && j != OWNER(v) ->
        announced[AT(OWNER(v), v)] = announced[AT(OWNER(v), v)] | (1 << j);
        to--
      :: skip
      fi
    }
  }
#endif
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
    me = 0; u = 0; v = 0; j = 0; i = 0; x = 0; w = 0; f = 0; last = 0; to = 0; words = 0; neighbours = 0; insert = 0; quiet = 0
  }
}

active proctype system() {
  atomic {
    for (j : 0 .. TILES - 1) {
      node[j] = j % NODES
    }
    choose_announced();
    reset()
  }
  do
#define STEPS(k)                                                                        \
  :: atomic { !up[k] -> me = k; begin(); reset() }                                       \
  :: atomic { up[k] && applied[k] < epoch -> me = k; apply_table(); reset() }            \
  :: atomic { up[k] && due[k] != 0 -> me = k; replay(); reset() }                        \
  :: atomic { HAS(ready, k) -> me = k; take(); reset() }
  STEPS(0)
  STEPS(1)
  STEPS(2)
#if TILES == 4
  STEPS(3)
#endif
#define CRASH(k) :: atomic { crashes > 0 && HAS(alive, k) && alive != (1 << (k)) -> lose(k); reset() }
  CRASH(0)
  CRASH(1)
  CRASH(2)
#if NODES == 4
  CRASH(3)
#endif
  :: else -> d_step { check_quiet(); assert(quiet); reset() } break
  od
}
