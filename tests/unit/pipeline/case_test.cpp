// Case files: what is read, what is refused, and with which words.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "lumesh/core/error.hpp"
#include "lumesh/metric/sources.hpp"
#include "lumesh/pipeline/pipeline.hpp"

namespace lumesh {
namespace {

class CaseFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) /
              ("case_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::filesystem::path write(const std::string& text) const {
    const std::filesystem::path path = folder_ / "a.toml";
    std::ofstream(path) << text;
    return path;
  }
  [[nodiscard]] Case read(const std::string& text, std::vector<std::string> settings = {}) const {
    return read_case(write(text), settings);
  }
  /// What is said of a bad case, without the folder.
  [[nodiscard]] std::string refusal(const std::string& text, std::vector<std::string> settings = {}) const {
    try {
      static_cast<void>(read(text, std::move(settings)));
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      std::string message = error.what();
      const std::string name = (folder_ / "a.toml").string();
      if (message.starts_with(name)) message = "a.toml" + message.substr(name.size());
      EXPECT_EQ(message.find('\n'), std::string::npos);
      return message;
    }
    return "accepted";
  }

  std::filesystem::path folder_;
};

TEST_F(CaseFile, ReadsKeysOfEverySectionAndKeepsDefaults) {
  const Case c = read(R"(mesher = "delaunay"
[input]
image = "images/a.nrrd"
labels = [1, 3, "left ICA"]
cut_planes = [[0, 0, 10, 0, 0, -1]]
[delaunay]
delta = 0.5
[metric]
points = "centerline"
k = 30
[adapt]
boundary = "frozen"
met = 1
meval = 1
reconstruct = 1
nqual = 7
[output]
meshes = ["a.vtu", "a.msh"]
)");
  EXPECT_EQ(c.name, "a");
  EXPECT_EQ(c.mesher, Mesher::kDelaunay);
  EXPECT_EQ(c.input.image, (folder_ / "images/a.nrrd").string()) << "relative to the case file";
  EXPECT_EQ(c.input.selection.labels, (std::vector<std::string>{"1", "3", "left ICA"}));
  ASSERT_EQ(c.input.cuts.planes.size(), 1U);
  EXPECT_EQ(c.input.cuts.planes[0].normal, Vec3(0, 0, -1));
  EXPECT_EQ(c.delaunay.delaunay.delta_mm, 0.5);
  EXPECT_EQ(c.metric.source<metric::PointSource>().options.k, 30);
  EXPECT_TRUE(c.needs_centerline());
  EXPECT_TRUE(c.adapt.boundary.is_frozen);
  EXPECT_EQ(c.adapt.adapt.quality_passes, 7) << "the paper's name of the key";
  EXPECT_EQ(c.adapt.adapt.smoothing_passes, AdaptOptions{}.smoothing_passes);
  EXPECT_EQ(c.output.meshes, (std::vector<std::string>{"a.vtu", "a.msh"}));
}

TEST_F(CaseFile, SettingsOfTheCommandLineGoFirst) {
  const Case c =
      read("[input]\nphantom = \"torus\"\n[metric]\nk = 30\n",
           {"metric.k=12", "metric.points=centerline", "output.meshes=[\"b.msh\"]", "run.checkpoints=true"});
  EXPECT_EQ(c.metric.source<metric::PointSource>().options.k, 12);
  EXPECT_EQ(c.metric.source<metric::PointSource>().points, "centerline");
  EXPECT_EQ(c.output.meshes, std::vector<std::string>{"b.msh"});
  EXPECT_TRUE(c.run.checkpoints);
}

TEST_F(CaseFile, NamesLineAndNearestWordOfAnUnknownKey) {
  EXPECT_EQ(refusal("[input]\nphantom = \"torus\"\n[metric]\ncomplexty = 5\n"),
            "a.toml:4: unknown key \"complexty\" in [metric]; did you mean \"complexity\"?");
  EXPECT_EQ(refusal("[inptu]\nphantom = \"torus\"\n"),
            "a.toml:1: unknown section \"inptu\"; did you mean \"input\"?");
  EXPECT_EQ(refusal("[input]\nphantom = \"torus\"\n[lattice]\nspacing = 2\n"),
            "a.toml: [lattice] is for mesher = \"lattice\", and the mesher is delaunay; set mesher or leave "
            "the section "
            "out");
  EXPECT_EQ(refusal("messer = \"lattice\"\n"), "a.toml:1: unknown key \"messer\"; did you mean \"mesher\"?");
}

TEST_F(CaseFile, RefusesWrongTypesAndRangesWithTheLine) {
  const std::string head = "[input]\nphantom = \"torus\"\n";
  EXPECT_EQ(refusal(head + "[metric]\nk = \"40\"\n"), "a.toml:4: [metric] k must be a whole number");
  EXPECT_EQ(refusal(head + "[metric]\nk = 40.5\n"), "a.toml:4: [metric] k must be a whole number");
  EXPECT_EQ(refusal(head + "[metric]\nk = 0\n"),
            "a.toml:4: [metric] k must lie between 1 and 10000, not at 0");
  EXPECT_EQ(refusal(head + "[metric]\ncomplexity = nan\n"),
            "a.toml:4: [metric] complexity must be greater than 0, or 0, not nan");
  EXPECT_EQ(refusal(head + "[metric]\ncomplexity = -1\n"),
            "a.toml:4: [metric] complexity must be greater than 0, or 0, not -1");
  EXPECT_EQ(refusal(head + "[metric]\ncurvature = 1\n"),
            "a.toml:4: [metric] curvature must be true or false");
  EXPECT_EQ(refusal(head + "[adapt]\nboundary = \"froze\"\n"),
            "a.toml:4: [adapt] boundary must be one of \"adapt\", \"frozen\", not \"froze\"");
  EXPECT_EQ(refusal(head + "[lattice]\nfidelity = 2\n"),
            "a.toml:4: [lattice] fidelity must lie between 0.1 and 0.98, not at 2");
  EXPECT_EQ(refusal("input = 3\n"), "a.toml:1: input is a section; write [input] in a line of its own");
  EXPECT_EQ(refusal("[input]\nphantom = [\n"),
            "a.toml:2: Error while parsing array: encountered end-of-file");
}

TEST_F(CaseFile, RefusesWhatContradictsItself) {
  EXPECT_EQ(refusal(""), "a.toml: [input] needs one of image, surface and phantom, not 0 of them");
  EXPECT_EQ(refusal("[input]\nphantom = \"torus\"\nimage = \"a.nrrd\"\n"),
            "a.toml: [input] needs one of image, surface and phantom, not 2 of them");
  const std::string head = "[input]\nphantom = \"torus\"\n";
  EXPECT_EQ(refusal(head + "[metric]\npoints = \"centerline\"\nmin_size = 2\nmax_size = 1\n"),
            "a.toml: [metric] min_size 2 is larger than [metric] max_size 1");
  EXPECT_EQ(refusal(head + "[adapt]\nnqual = 3\nquality_passes = 4\n"),
            "a.toml:4: nqual is another name of [adapt] quality_passes, which is given, too; leave one out");
  EXPECT_EQ(refusal(head + "[output]\nmeshes = [\"a.vtu\", \"a.vtu\"]\n"),
            "a.toml: [output] a.vtu is named for two files; give each its own name");
  EXPECT_EQ(refusal("[input]\nimage = \"a.nrrd\"\n[metric]\nvelocity = \"phantom\"\n"),
            "a.toml: [metric] velocity = \"phantom\" needs [input] phantom");
  for (const char* text :
       {"[.a]\nx = 1\n", "[# x\n", ".=1\n", "[[\n", "a..b = 1\n", "= 1\n", "[a\n", "\x01 = 2\n"})
    EXPECT_EQ(refusal(text).substr(0, 7), "a.toml:") << text;
  EXPECT_EQ(refusal("[input]\nimage = \"a.nrrd\"\nthreshold = 1\nbelow = 2\n"),
            "a.toml: [input] threshold and below exclude each other; give one of them");
  for (const char* own : {"[delaunay] delta", "[delaunay] edge_length", "[lattice] edge_length"}) {
    const std::string section(own, std::string_view(own).find(']') + 1), key(own + section.size() + 1);
    const std::string mesher = section == "[lattice]" ? "mesher = \"lattice\"\n" : "";
    EXPECT_EQ(refusal("edge_length = 0.5\n" + mesher + head + section + "\n" + key + " = 0.6\n"),
              std::string("a.toml: edge_length and ") + own +
                  " exclude each other; give one of them (0 leaves one out)");
    EXPECT_EQ(refusal("edge_length = 0.5\n" + mesher + head + section + "\n" + key + " = 0.6\n",
                      {section.substr(1, section.size() - 2) + "." + key + "=0"}),
              "accepted");
  }
  EXPECT_EQ(refusal("cells_per_diameter = 8\nmesher = \"lattice\"\n" + head + "[lattice]\nfidelity = 0.9\n"),
            "a.toml: cells_per_diameter and [lattice] fidelity exclude each other; give one of them");
}

/// Whatever stands in a file: a case, or one line.
TEST_F(CaseFile, NamesEverySourceOfSizesWhereOneIsMissing) {
  const std::string head = "[input]\nphantom = \"torus\"\n";
  std::string sources;  // Those that have no value for each vertex of another mesh.
  for (const std::string& name : metric::MetricRequest::source_options())
    if (name != "metric" && name != "hessian") sources += (sources.empty() ? "" : ", ") + name;
  sources.replace(sources.rfind(", "), 2, " or ");
  EXPECT_EQ(refusal(head + "[metric]\ncomplexity = 100\n"),
            "a.toml: [metric] complexity has nothing to scale; give " + sources);
  EXPECT_EQ(refusal(head + "[adapt]\nboundary = \"frozen\"\n"),
            "a.toml: [adapt] changes nothing without sizes; give " + sources +
                " in [metric], or leave the section out");
}

TEST_F(CaseFile, RandomChangesAreReadOrRefused) {
  const std::string good =
      "mesher = \"lattice\"\n[input]\nphantom = \"torus\" # a ring\n[lattice]\nspacing = 2.5\n[layers]\n"
      "patch = [\"wall\",\n 'inlet_1']\nfirst_height = 1e-1\n[a.b]\nc = { d = 2020-01-01, e = 0xff }\n";
  constexpr std::uint64_t kSeed = 7;
  std::mt19937_64 random(kSeed);
  const std::string alphabet = "[]{}.=\"'#,\n\r\t \\x0b1eE+-_:u\x01\xff";
  for (int i = 0; i < 4000; ++i) {
    std::string text = good;
    for (std::size_t n = 1 + random() % 4; n > 0; --n) {
      const std::size_t at = random() % text.size();
      if (random() % 3 == 0)
        text.erase(at, 1 + random() % 8);
      else
        text.insert(at, 1, alphabet[random() % alphabet.size()]);
    }
    try {
      (void)read(text);
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos)
          << "seed " << kSeed << ": " << error.what();
    }
  }
}

TEST_F(CaseFile, ReadsLayersWithTheNamesOfTheOptions) {
  const std::string head = "[input]\nphantom = \"torus\"\n[layers]\n";
  const Case c = read(head +
                          "blds = 0.1\nnbl = 3\nblr = 1.3\npatch = [\"wall\"]\nside = \"inward\"\ncells = "
                          "\"prisms\"\nrelative_to = \"radius\"\nlabel = \"blood=4\"\n",
                      {"layers.count=5"});
  const LayerOptions& o = c.layers.options;
  EXPECT_TRUE(c.layers.is_wanted());
  EXPECT_EQ(o.first_height, 0.1);
  EXPECT_EQ(o.count, 5) << "of the command line";
  EXPECT_EQ(o.growth, 1.3);
  EXPECT_EQ(o.patches, std::vector<std::string>{"wall"});
  EXPECT_EQ(o.side, LayerSide::kInward);
  EXPECT_EQ(o.cells, LayerCells::kPrisms);
  EXPECT_EQ(o.scale, HeightScale::kRadius);
  EXPECT_EQ(o.label, 4);
  EXPECT_EQ(o.label_name, "blood");
  EXPECT_EQ(case_text(read(case_text(c))), case_text(c));
  EXPECT_FALSE(read("[input]\nphantom = \"torus\"\n").layers.is_wanted());
}

TEST_F(CaseFile, RefusesLayersThatCannotBe) {
  const std::string head = "[input]\nphantom = \"torus\"\n[layers]\n";
  const auto begins = [&](const std::string& keys, const std::string& words) {
    const std::string message = refusal(head + keys);
    EXPECT_EQ(message.substr(0, words.size()), words);
  };
  begins("count = 3\n", "a.toml: [layers] first_height is missing");
  begins("first_height = 0.1\ngrowth = 1\n",
         "a.toml: layers that do not grow never become as high as edges are long; give [layers] count or "
         "[layers] thickness");
  EXPECT_EQ(refusal(head + "blds = 0.1\nmbl = 1\nfints = 0\nopen = true\n"), "accepted") << "as AFLR's line";
  begins("first_height = 0.1\nfints = 1\n", "a.toml:5: [layers] fints must");
  begins("first_height = 0.1\ngrowth = 0.9\nthickness = 1\n",
         "a.toml: a growth below 1 needs the number of layers, [layers] count");
  begins("first_height = 0.1\ncount = 2\nlabel = \"wall=x\"\n",
         "a.toml:6: [layers] label \"wall=x\": \"x\" is no whole number");
  begins("first_height = 0.1\ncount = 2\nlabel = \"-1\"\n",
         "a.toml:6: [layers] label \"-1\": labels are above 0");
  begins("first_height = 0.1\ncount = 201\n",
         "a.toml:5: [layers] count must lie between 1 and 200, or 0, not at 201");
  begins("first_height = 0.1\ncount = 2\ncells = \"hexes\"\n",
         "a.toml:6: [layers] cells must be one of \"prisms\", \"tetrahedra\"");
  begins("first_heigth = 0.1\n", "a.toml:4: unknown key \"first_heigth\" in [layers]; did you mean");
  const std::string prisms = "first_height = 0.1\ncount = 2\ncells = \"prisms\"\n[output]\nmeshes = ";
  begins(prisms + "[\"a.vtu\", \"a.xdmf\"]\n", "a.toml: [output] meshes: a.xdmf holds tetrahedra only");
  begins(prisms + "[\"b-mesh-complete\"]\n",
         "a.toml: [output] meshes: b-mesh-complete holds tetrahedra only");
  begins(prisms + "[\"a.foam\", \"b.foam\"]\n", "a.toml: [output] meshes: b.foam would replace the mesh of");
  EXPECT_EQ(refusal(head + prisms + "[\"a.foam\", \"a.msh\", \"a.meshb\"]\n"), "accepted");
}

TEST_F(CaseFile, ASettingThatIsNoneSaysHowToWriteIt) {
  const std::filesystem::path path = write("[input]\nphantom = \"torus\"\n");
  const std::vector<std::string> settings = {"k"};
  try {
    static_cast<void>(read_case(path, settings));
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage);
    EXPECT_STREQ(error.what(), "--set k: write SECTION.KEY=VALUE, such as metric.k=40");
  }
  EXPECT_EQ(refusal("[input]\nphantom = \"torus\"\n", {"metric.k=many"}),
            "--set metric.k=many: [metric] k must be a whole number");
}

TEST_F(CaseFile, MessagesNameItsKeys) {
  Case c = read("[input]\nphantom = \"torus\"\n");
  EXPECT_EQ(c.with_keys("`edge_length`, `first_height`, `x`"), "edge_length, [layers] first_height, `x`");
  c.delaunay.delaunay.delta_mm = 2;  // The key that the case has: another one would be refused.
  EXPECT_EQ(c.with_keys("a smaller `edge_length` makes more"), "a smaller [delaunay] delta makes more");
  c.mesher = Mesher::kLattice;
  c.lattice.spacing_mm = 2;
  EXPECT_EQ(c.with_keys("a smaller `delta` makes more"), "a smaller [lattice] edge_length makes more");
}

TEST_F(CaseFile, RefusesKeysForAnotherKindOfInput) {
  const auto refused = [&](const std::string& input, const std::string& key) {
    return refusal("mesher = \"delaunay\"\n[input]\n" + input + "\n" + key + "\n");
  };
  for (const char* key : {"patch_array = \"ids\"", "keep_open = true", "feature_angle = 30.5"}) {
    const std::string name = std::string(key).substr(0, std::string(key).find(' '));
    for (const char* input : {"image", "phantom"})
      EXPECT_EQ(refused(std::string(input) + " = \"torus\"", key),
                "a.toml: [input] " + name + " is for surfaces; leave it out with " + input);
    EXPECT_EQ(refused("surface = \"a.stl\"", key), "accepted");
  }
  for (const char* input : {"image", "surface"})
    EXPECT_EQ(refused(std::string(input) + " = \"a.stl\"", "phantom_noise = 0.5"),
              std::string("a.toml: [input] phantom_noise is for phantoms; leave it out with ") + input);
  EXPECT_EQ(refused("surface = \"a.stl\"", "boundary = \"exact\""),
            "a.toml: [input] boundary is for images; leave it out with surface");
  EXPECT_EQ(refused("image = \"a.nrrd\"", "labels = [1]\nthreshold = 1"),
            "a.toml: [input] labels and threshold exclude each other; give one of them");
}

/// The tables show it for what is empty.
TEST_F(CaseFile, NoneMakesAKeyEmpty) {
  const std::string text = R"([input]
phantom = "torus"
extend = "5r"
drop_below = 3
cut_at = [[1, 2, 3]]
labels = [1]
threshold = 0.5
label_images = ["a.nrrd=2"]
[run]
time_limit = 5
)";
  std::vector<std::string> settings = {"output.report=none"};
  for (const char* key : {"input.extend", "input.drop_below", "input.cut_at", "input.labels",
                          "input.threshold", "input.label_images", "run.time_limit"})
    settings.push_back(std::string(key) + "=none");
  const Case c = read(text, settings), untouched = read("[input]\nphantom = \"torus\"\n");
  EXPECT_EQ(c.input.cuts.extension.lengths.size(), 0U);
  EXPECT_EQ(differing_options(c.input, untouched.input), std::vector<std::string>());
  EXPECT_EQ(differing_options(c.run, untouched.run), std::vector<std::string>());
  EXPECT_EQ(c.output.report, "");
  EXPECT_EQ(
      differing_options(read("[input]\nphantom = \"torus\"\nextend = \"none\"\n").input, untouched.input),
      std::vector<std::string>());
  EXPECT_EQ(refusal(text, {"metric.k=none"}), "--set metric.k=none: [metric] k must be a whole number");
  EXPECT_NE(refusal(text, {"adapt.boundary=none"}).find("must be one of"), std::string::npos);
}

/// Warnings write a place so: "cut it square with [input] cut_at 1,-2.5,0.1".
TEST_F(CaseFile, OneRowOfNumbersIsAListOrATextByItself) {
  const std::string head = "[input]\nphantom = \"torus\"\n";
  const std::vector<Vec3> place = {{1, -2.5, 0.1}};
  for (const char* row :
       {"[[1, -2.5, 0.1]]", "[1, -2.5, 0.1]", "\"1,-2.5,0.1\"", "[\"1,-2.5,0.1\"]", "\"1, -2.5, 0.1\""})
    EXPECT_EQ(read(head + "cut_at = " + row + "\n").input.cuts.places_mm, place) << row;
  EXPECT_EQ(read(head, {"input.cut_at=1,-2.5,0.1"}).input.cuts.places_mm, place);
  EXPECT_EQ(read(head + "phantom_spacing = \"1,2,3\"\n").input.phantom_spec.spacing_mm, Vec3(1, 2, 3));
  for (const char* row : {"[1, -2.5]", "\"1,-2.5\"", "\"1,-2.5,far\"", "[1, -2.5, [0.1]]"})
    EXPECT_EQ(refusal(head + "cut_at = " + row + "\n").substr(0, 24), "a.toml:3: [input] cut_at") << row;
  EXPECT_EQ(refusal(head + "phantom_spacing = \"1,-2,3\"\n"),
            "a.toml:3: [input] phantom_spacing must be greater than 0, or 0, not -2");
}

TEST_F(CaseFile, TheTextOfACaseReadsAsTheSameCase) {
  const Case c = read(R"([input]
image = 'an image.nrrd'
threshold = 0.1
cut_planes = [[0, 0, 10.125, 0.3333333333333333, 0, -1], [1, 2, 3, 4, 5, 6]]
cut_at = [[1, -2.5, 0.1]]
[metric]
points = "centerline"
gradation = 1.3
[adapt]
execution = "speculative"
)");
  const std::string text = case_text(c);
  const Case again = read(text);
  EXPECT_EQ(case_text(again), text);
  EXPECT_EQ(again.input.cuts.planes[0].normal.x(), 0.3333333333333333);
  EXPECT_EQ(again.input.cuts.places_mm, (std::vector<Vec3>{{1, -2.5, 0.1}}));
  EXPECT_EQ(again.input.selection.threshold, 0.1);
  EXPECT_EQ(again.adapt.adapt.execution, ExecutionKind::kSpeculative);
  const std::string of_phantom =
      case_text(read("[input]\nphantom = \"torus\"\nphantom_spacing = [1, 2, 3]\n"));
  EXPECT_EQ(case_text(read(of_phantom)), of_phantom);
  EXPECT_EQ(read(of_phantom).input.phantom_spec.spacing_mm, Vec3(1, 2, 3));
}

}  // namespace
}  // namespace lumesh
