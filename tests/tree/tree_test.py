"""That the walls of tree.py see a breach: in a small project of two libraries and a program."""

import unittest

import tree

LINKS = """target tessera_low STATIC_LIBRARY src/low
source low.cc
target tessera_high STATIC_LIBRARY src/high
source high.cc
public tessera_low
target high_test EXECUTABLE tests/high
source high_test.cc
private tessera_high
"""

TEXTS = {
    "src/low/low.h": "",
    "src/low/low.cc": '#include "src/low/low.h"\n',
    "src/high/high.h": '#include <vector>\n\n#include "src/low/low.h"\n',
    "src/high/high.cc": '#include "src/high/high.h"\n',
    "tests/high/helpers.h": '#include "src/high/high.h"\n',
    "tests/high/high_test.cc": '#include "tests/high/helpers.h"\n',
}


class Walls(unittest.TestCase):
    def needs(self, target, changed=()):
        walls = tree.Walls(tree.targets(LINKS), {**TEXTS, **dict(changed)})
        return tuple(set(kind) for kind in walls.needs(walls.targets[target]))

    def test_what_a_header_includes_is_public(self):
        self.assertEqual(self.needs("tessera_high"), ({"tessera_low"}, set()))

    def test_what_only_a_source_includes_is_private(self):
        changed = {"src/high/high.h": "", "src/high/high.cc": '#include "src/low/low.h"\n'}
        self.assertEqual(self.needs("tessera_high", changed), (set(), {"tessera_low"}))

    def test_a_header_that_no_source_includes_counts(self):
        changed = {"src/low/other.h": '#include "src/high/high.h"\n'}
        self.assertEqual(self.needs("tessera_low", changed), ({"tessera_high"}, set()))

    def test_what_a_test_includes_through_its_own_header_counts_and_what_that_includes_does_not(self):
        self.assertEqual(self.needs("high_test"), (set(), {"tessera_high"}))

    def test_a_header_of_nobody_is_told(self):
        walls = tree.Walls(tree.targets(LINKS), {**TEXTS, "src/low/low.cc": '#include "src/gone/gone.h"\n'})
        self.assertEqual(walls.needs(walls.targets["tessera_low"])[1],
                         {None: "src/low/low.cc includes src/gone/gone.h"})

    def test_links_are_read_with_their_kind(self):
        targets = tree.targets(LINKS)
        self.assertEqual(targets["tessera_high"].public, {"tessera_low"})
        self.assertEqual(targets["high_test"].private, {"tessera_high"})
        self.assertEqual(targets["high_test"].sources, ["tests/high/high_test.cc"])


class Types(unittest.TestCase):
    def test_those_of_named_namespaces_are_found(self):
        text = """namespace a::b {  // struct Not {};
struct One { struct Inner {}; };
template <class T>
class Two final : public One { const char* text = "struct Not { //"; };
enum class Three : char { x };
class Declared;
inline void f() { struct Local {}; }
namespace { struct Hidden {}; }
}
"""
        self.assertEqual(tree.types_in(text), ["a::b::One", "a::b::Two", "a::b::Three"])


class Functions(unittest.TestCase):
    def test_their_lines_are_counted(self):
        text = """namespace a {
struct One {
  int inside() const { return 1; }
  One() : x_{1} {
  }
};
int f(int a,
      int b) {  // }
  const auto g = [] {
    return "}";
  };
  if (a) {
  }
}
const char* const table[] = {"f() {"};
}
"""
        self.assertEqual(tree.functions_in(text), [("inside", 1), ("One", 2), ("f", 8)])

    def test_classes_are_those_with_members_outside(self):
        text = """namespace a::b {
namespace {
struct One {
  int inside() const { return 1; }
};
}
Two::Two(int x) : x_(x) {}
std::vector<int> Two::Impl::all() const { return Other::all(); }
int c::Three::f() { return 0; }
int d::f() { return 0; }
int f() { return 0; }
}
"""
        self.assertEqual(tree.classes_in(text), {("a::b", "Two"), ("a::b", "Three")})


class Rooms(unittest.TestCase):
    README = """# X

    z/

## The way of the data

Of src/none/.

    src/low/   first
               more/ of it
    a/ b/c/    two

## Limits

    d/
"""

    def test_rooms_are_the_folders_at_the_begin_of_a_line(self):
        self.assertEqual(tree.rooms(self.README), ["src/low", "a", "b/c"])

    def test_a_file_is_in_the_innermost_room(self):
        self.assertEqual(tree.room_of("a/b/x.h", ["a", "a/b"]), "a/b")
        self.assertIsNone(tree.room_of("ab/x.h", ["a"]))

    def test_public_headers_and_generated_ones_have_rooms_of_their_own(self):
        self.assertEqual(tree.includes('#include <tessera/a.h>\n#include <vector>\n#include "b.pb.h"\n'),
                         ["tessera/a.h", "b.pb.h"])
        self.assertEqual(tree.place_of("tessera/a.h"), "include/tessera/a.h")
        self.assertEqual(tree.place_of("b.pb.h"), "proto/b.pb.h")


if __name__ == "__main__":
    unittest.main()
