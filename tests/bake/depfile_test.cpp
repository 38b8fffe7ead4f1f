// The depfile's syntax; tests/commands has make and ninja read one.
#include "bake/depfile.h"

#include <gtest/gtest.h>

namespace overcast {
namespace {

TEST(Depfile, EscapesWhatHasAMeaning) {
  const auto text = depfileText({{"out/my scene.gltf", {"a#b.off", "c$d.off", "e\\ f.off", "g:h.off", "i\\j.off"}}, {"two", {"a#b.off"}}});
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(text.value(),
            "out/my\\ scene.gltf: \\\n  a\\#b.off \\\n  c$$d.off \\\n  e\\\\\\ f.off \\\n  g\\:h.off \\\n  i\\j.off\n"
            "two: \\\n  a\\#b.off\n"
            "a\\#b.off:\nc$$d.off:\ne\\\\\\ f.off:\ng\\:h.off:\ni\\j.off:\n");
}

TEST(Depfile, AnInputThatIsAlsoATargetHasOneRule) {
  const auto text = depfileText({{"b", {"a"}}, {"c", {"b"}}});
  ASSERT_TRUE(text.ok());
  EXPECT_EQ(text.value(), "b: \\\n  a\nc: \\\n  b\na:\n");
}

TEST(Depfile, RefusesLineBreaks) {
  EXPECT_FALSE(depfileText({{"out", {"a\nb"}}}).ok());
  EXPECT_FALSE(depfileText({{"o\rut", {"a"}}}).ok());
}

}  // namespace
}  // namespace overcast
