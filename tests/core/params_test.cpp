#include "scslam/core/params.h"

#include "support/support.h"

namespace scslam {
namespace {

struct Inner : ParamSetOf<Inner> {
  double voxel_m = 0.1;
  int count = 3;
  void describe(ParamVisitor& v) override {
    v.field("voxel_m", voxel_m, "edge of a voxel [m]", 0.01, 10);
    v.field("count", count, "how many", 1, 100);
  }
};

struct Outer : ParamSetOf<Outer> {
  bool on = true;
  std::string kind = "fast";
  std::vector<double> offsets = {1, 2.5};
  std::vector<std::string> colours = {"red"};
  double limit = std::numeric_limits<double>::infinity();
  Inner inner;
  void describe(ParamVisitor& v) override {
    v.field("on", on, "switch");
    v.field("kind", kind, "which", {"fast", "careful"});
    v.field("offsets", offsets, "offsets [m]");
    v.field("limit", limit, "limit [m]");
    v.field("colours", colours, "which colours", {"red", "green", "blue"});
    v.group("inner", inner, "the inner part");
  }
};

std::string complaint(const std::string& yaml) {
  Outer params;
  try {
    loadYaml(params, yaml, "my.yaml");
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kUsage);
    return error.what();
  }
  return "accepted";
}

TEST(Params, AListOfNamesTakesOnlyItsChoicesEachOnce) {
  Outer params;
  loadYaml(params, "colours: [blue, red]", "my.yaml");
  EXPECT_EQ(params.colours, (std::vector<std::string>{"blue", "red"}));
  setParam(params, "colours=green");
  EXPECT_EQ(params.colours, std::vector<std::string>{"green"});
  Outer again;
  loadYaml(again, dumpYaml(params), "dump");
  EXPECT_EQ(again.colours, params.colours);
  EXPECT_EQ(complaint("colours: [red, gren]"),
            "my.yaml:1:16: colours cannot be 'gren'; did you mean 'green'? (known: red, green, blue)");
  EXPECT_EQ(complaint("colours: [red, red]"), "my.yaml:1:16: colours names 'red' twice");
  EXPECT_EQ(complaint("colours: {a: 1}"), "my.yaml:1:10: colours must be a list of names: [one, two]");
}

TEST(Params, KeysThatAreGivenReplaceDefaultsAndOthersStay) {
  Outer params;
  loadYaml(params, "on: false\ninner:\n  voxel_m: 0.25\noffsets: [3]\n", "my.yaml");
  EXPECT_FALSE(params.on);
  EXPECT_EQ(params.inner.voxel_m, 0.25);
  EXPECT_EQ(params.inner.count, 3);
  EXPECT_EQ(params.offsets, std::vector<double>{3});
}

TEST(Params, UnknownKeyIsRefusedWithPlaceAndSuggestion) {
  EXPECT_THAT(complaint("on: true\ninner:\n  voxel_n: 1\n"),
              testing::AllOf(testing::HasSubstr("my.yaml:3:3"), testing::HasSubstr("inner.voxel_n"),
                             testing::HasSubstr("did you mean 'voxel_m'")));
}

TEST(Params, WrongTypeRangeChoiceAndSyntaxNameTheirPlace) {
  EXPECT_THAT(complaint("inner: {count: 2.5}"),
              testing::HasSubstr("my.yaml:1:16: inner.count must be a whole number, not '2.5'"));
  EXPECT_THAT(complaint("inner: {voxel_m: 99}"), testing::HasSubstr("outside [0.01, 10]"));
  EXPECT_THAT(complaint("inner: {voxel_m: .nan}"), testing::HasSubstr("NaN"));
  EXPECT_THAT(complaint("kind: quick"), testing::HasSubstr("cannot be 'quick'"));
  EXPECT_THAT(complaint("on: [1, 2"), testing::HasSubstr("my.yaml:"));
  EXPECT_THAT(complaint("on: perhaps"), testing::HasSubstr("true or false"));
  EXPECT_THAT(complaint("- 1\n- 2\n"), testing::HasSubstr("key: value"));
  EXPECT_THAT(complaint("on: true\non: false\n"), testing::HasSubstr("my.yaml:2:1: key 'on' stands twice"));
  EXPECT_THAT(complaint("inner: 3"), testing::HasSubstr("'inner' must be"));
  EXPECT_EQ(complaint(""), "accepted");
}

TEST(Params, DumpReadsBackToTheSameValues) {
  Outer params;
  params.inner.voxel_m = 0.1 + 0.2;
  params.kind = "careful";
  for (const bool documented : {false, true}) {
    Outer back;
    loadYaml(back, dumpYaml(params, documented), "dump");
    EXPECT_EQ(back.inner.voxel_m, params.inner.voxel_m);
    EXPECT_EQ(back.kind, "careful");
    EXPECT_EQ(back.limit, params.limit);
    EXPECT_EQ(dumpYaml(back), dumpYaml(params));
  }
}

TEST(Params, SetChangesOneFieldAndComplainsLikeAFile) {
  Outer params;
  setParam(params, "inner.count=7");
  setParam(params, "kind=careful");
  setParam(params, "offsets=[4, 5]");
  EXPECT_EQ(params.inner.count, 7);
  EXPECT_EQ(params.kind, "careful");
  EXPECT_EQ(params.offsets, (std::vector<double>{4, 5}));
  EXPECT_THROW(setParam(params, "inner.cuont=7"), Error);
  EXPECT_THROW(setParam(params, "inner"), Error);
  EXPECT_THROW(setParam(params, "=3"), Error);
}

TEST(Params, SchemaListsEveryKey) {
  const std::string schema = schemaJson(Outer{});
  for (const char* key :
       {"\"on\"", "\"kind\"", "\"offsets\"", "\"inner\"", "\"voxel_m\"", "\"enum\"", "\"minimum\": 0.01"})
    EXPECT_THAT(schema, testing::HasSubstr(key));
}

}  // namespace
}  // namespace scslam
