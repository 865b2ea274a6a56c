#!/usr/bin/env python3
"""Tests the checks in scripts/: each must find a planted fault and accept a clean tree."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
import option_tables  # noqa: E402


class ChecksTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        self.write_modules("core", "parallel DEPENDS core", "image DEPENDS core", "mesh DEPENDS core", "io DEPENDS image mesh ALONE itk.cpp",
                           "lattice DEPENDS mesh", "adapt DEPENDS mesh")
        self.write("include/lumesh/core/types.hpp", "#pragma once\n")
        self.write("include/lumesh/mesh/tet_mesh.hpp", '#pragma once\n#include "lumesh/core/types.hpp"\n')
        self.write("src/mesh/tet_mesh.cpp", '#include "lumesh/mesh/tet_mesh.hpp"\nint three() {\n  return 3;\n}\n')

    def tearDown(self):
        self.folder.cleanup()

    def write(self, path, text):
        (self.root / path).parent.mkdir(parents=True, exist_ok=True)
        (self.root / path).write_text(text)

    def write_modules(self, *modules):
        self.write("CMakeLists.txt", "".join(f"lumesh_module({module})\n" for module in (*modules, "pipeline DEPENDS mesh")))

    def run_check(self, name):
        result = subprocess.run([sys.executable, SCRIPTS / name, self.root], capture_output=True, text=True, check=False)
        self.assertEqual(result.stderr, "")
        return result.returncode, result.stdout

    def assert_finds(self, name, words):
        status, output = self.run_check(name)
        self.assertEqual(status, 1, output)
        self.assertIn(words, output)

    def test_a_clean_tree_passes(self):
        for name in ("check_layers.py", "check_sizes.py", "check_primitives.py"):
            self.assertEqual(self.run_check(name)[0], 0, name)

    def test_a_tree_without_files_is_a_fault(self):
        with tempfile.TemporaryDirectory() as folder:
            for self.root in (pathlib.Path(folder), pathlib.Path(folder, "nonexistent")):
                for name in ("check_layers.py", "check_sizes.py", "check_primitives.py", "check_references.py", "check_words.py"):
                    status, output = self.run_check(name)
                    self.assertEqual(status, 1, name)
                    self.assertIn(f"{self.root}: no file to check", output)
                    self.assertIn("1 faults", output)

    def test_layers_takes_the_modules_of_the_tree_that_it_checks(self):
        self.write("src/mesh/bad.cpp", '#include "lumesh/image/label_image.hpp"\n')
        self.write("include/lumesh/image/label_image.hpp", "#pragma once\n")
        self.assert_finds("check_layers.py", "mesh may not include lumesh/image/label_image.hpp")
        self.write_modules("core", "image DEPENDS core", "mesh DEPENDS image")
        self.assertEqual(self.run_check("check_layers.py")[0], 0)
        self.write_modules("image", "mesh DEPENDS image")
        self.assert_finds("check_layers.py", "module core is not in CMakeLists.txt")

    def same_bits(self, body):
        """Of a program that is a shell script: every word with a dot is a file that it writes."""
        program = self.root / "program"
        program.write_text(f'#!/bin/sh\n{body}\n')
        program.chmod(0o755)
        result = subprocess.run([sys.executable, SCRIPTS / "check_same_bits.py", program], capture_output=True, text=True, check=False)
        self.assertEqual(result.stderr, "")
        return result.returncode, result.stdout

    def test_same_bits_finds_commands_that_fail_alike_and_files_that_differ(self):
        write = 'for word; do case $word in *.*) echo "$1" > "$word";; esac; done'
        status, output = self.same_bits(write)
        self.assertEqual(status, 0, output)
        self.assertIn("2 runs, 0 differences, 0 failed", output)
        for body, words in (("exit 1", "exit code 1, no message"), (f"[ $1 = adapt ] && echo bad >&2 && exit 2; {write}", "exit code 2, bad"),
                            (f"[ $1 = adapt ] && exit; {write}", "adapted.vtu was not written"),
                            (write.replace("$1", "$*"), "b.nrrd, lattice.vtu")):
            status, output = self.same_bits(body)
            self.assertEqual(status, 1, output)
            self.assertIn(words, output)

    def test_layers_finds_an_include_of_a_higher_module(self):
        self.write("include/lumesh/io/mesh_file.hpp", "#pragma once\n")
        self.write("src/mesh/bad.cpp", '#include "lumesh/io/mesh_file.hpp"\n')
        self.assert_finds("check_layers.py", "mesh may not include lumesh/io/mesh_file.hpp")

    def test_layers_finds_a_stage_that_uses_another_stage(self):
        self.write("include/lumesh/lattice/lattice.hpp", "#pragma once\n")
        self.write("src/adapt/bad.cpp", '#include "lumesh/lattice/lattice.hpp"\n')
        self.assert_finds("check_layers.py", "adapt may not include lumesh/lattice/lattice.hpp")

    def test_layers_finds_a_private_header_of_another_module(self):
        self.write("src/core/hidden.hpp", "#pragma once\n")
        self.write("src/mesh/bad.cpp", '#include "../core/hidden.hpp"\n')
        self.assert_finds("check_layers.py", "reaches out of its folder")

    def test_layers_finds_a_module_that_is_not_in_the_table(self):
        self.write("src/helpers/bad.cpp", "int one();\n")
        self.assert_finds("check_layers.py", "module helpers is not in CMakeLists.txt")

    def test_layers_accepts_the_header_for_plain_c_and_finds_what_it_includes(self):
        self.write("include/lumesh/sizing.h", "#pragma once\n")
        self.write("src/mesh/good.cpp", '#include "lumesh/sizing.h"\n')
        self.assertEqual(self.run_check("check_layers.py")[0], 0)
        self.write("include/lumesh/sizing.h", '#pragma once\n#include "lumesh/core/types.hpp"\n')
        self.assert_finds("check_layers.py", "a header for plain C includes nothing of lumesh")

    def test_layers_finds_a_heavy_library_in_a_public_header(self):
        self.write("include/lumesh/image/bad.hpp", "#pragma once\n#include <itkImage.h>\n")
        self.assert_finds("check_layers.py", "a shared header includes ITK")

    def test_layers_finds_a_header_of_the_api_that_includes_an_internal_one(self):
        self.write("internal/lumesh/core/box.hpp", "#pragma once\n")
        self.write("src/mesh/good.cpp", '#include "lumesh/core/box.hpp"\n')
        self.assertEqual(self.run_check("check_layers.py")[0], 0)
        self.write("include/lumesh/mesh/bad.hpp", '#pragma once\n#include "lumesh/core/box.hpp"\n')
        self.assert_finds("check_layers.py", "a header of the API includes lumesh/core/box.hpp")

    def test_layers_finds_a_header_of_the_api_that_nothing_named_needs(self):
        self.write("docs/api.md", "`mesh/tet_mesh.hpp` is what a user needs.\n")
        self.assertEqual(self.run_check("check_layers.py")[0], 0)
        self.write("include/lumesh/mesh/spare.hpp", "#pragma once\n")
        self.assert_finds("check_layers.py", "include/lumesh/mesh/spare.hpp: docs/api.md does not name it")

    def test_layers_finds_a_header_that_stands_in_both(self):
        self.write("internal/lumesh/core/types.hpp", "#pragma once\n")
        self.assert_finds("check_layers.py", "lumesh/core/types.hpp stands in include and internal")

    def test_layers_finds_a_second_file_with_itk(self):
        for name in ("one", "two"):
            self.write(f"src/io/{name}.cpp", "#include <itkImage.h>\n")
        self.assert_finds("check_layers.py", "ITK is included by 2 files of src, 1 may")

    def test_primitives_finds_threads_outside_the_parallel_module(self):
        for line in ("std::thread t;", "std::atomic<int> a;", "tbb::parallel_for(0, 2, f);", "#pragma omp parallel",
                     "#include <mutex>", "std::atomic_ref word(x);"):
            self.write("src/mesh/bad.cpp", f"{line}\n")
            self.assert_finds("check_primitives.py", "src/mesh/bad.cpp:1")

    def test_primitives_accepts_them_in_comments_strings_and_the_parallel_module(self):
        self.write("src/mesh/good.cpp", '// std::thread\nconst char* s = "std::mutex";  /* tbb::x */\n')
        self.write("src/parallel/good.cpp", "std::thread t;\n")
        self.assertEqual(self.run_check("check_primitives.py")[0], 0)

    def test_primitives_finds_variables_without_an_owner(self):
        self.write("src/parallel/bad.cpp", "int& f() {\n  static std::optional<int> count;\n  return *count;\n}\n")
        self.assert_finds("check_primitives.py", "src/parallel/bad.cpp:2: static std::optional<int> count;")
        self.write("src/parallel/bad.cpp", "  static constexpr int kA = 1;\n  static const Table table = read();\n  static int f(int a);\n")
        self.assertEqual(self.run_check("check_primitives.py")[0], 0)

    def test_references_finds_a_doi_that_is_missing(self):
        self.write("docs/references.bib", "@article{a,\n  author = {Known, Ann},\n  year = {1990},\n  doi = {10.1000/(SICI)1:2<3::A>4.0.CO;2-9}\n}\n")
        self.write("src/mesh/cited.cpp", "// Known 1990, doi:10.1000/(SICI)1:2<3::A>4.0.CO;2-9).\n")
        self.assertEqual(self.run_check("check_references.py")[0], 0)
        self.write("docs/page.md", "[doi:10.1000/xyz.5](https://doi.org/10.1000/xyz.5).\n")
        self.assert_finds("check_references.py", "docs/page.md:1: 10.1000/xyz.5 is missing")

    def test_references_finds_authors_and_years_that_are_missing(self):
        self.write("docs/references.bib", "@book{a,\n  author = {de Boor, Carl and Kåsa, I.},\n  year = {1978}\n}\n")
        self.write("src/mesh/cited.cpp", "/// As de\n/// Boor 1978, Kasa\n/// (1978), Boor and Other 1978, Other, Third and Kasa 1978; OpenFOAM 2012.\n")
        self.assertEqual(self.run_check("check_references.py")[0], 0, self.run_check("check_references.py")[1])
        for text in ("Boor 1979", "Other and\n/// Third 1978", "Other et al. (1978)"):
            self.write("src/mesh/cited.cpp", f"/// Source: {text}.\n")
            self.assert_finds("check_references.py", "src/mesh/cited.cpp: " + text.replace("\n///", "").replace("(", "").replace(")", "") + " is missing")

    def test_references_finds_a_heading_that_is_missing(self):
        self.write("docs/references.bib", "")
        self.write("docs/stages/a.md", "# a\n\n### Large steps\n")
        self.write("src/mesh/derived.cpp", '/// Derived in docs/stages/a.md, "Large\n/// steps".\n')
        self.assertEqual(self.run_check("check_references.py")[0], 0)
        self.write("src/mesh/derived.cpp", '/// Derived in docs/stages/a.md,\n/// "Small steps".\n')
        self.assert_finds("check_references.py", 'docs/stages/a.md has no heading "Small steps"')

    def test_words_finds_doc_lines_without_their_noun_beyond_the_budget(self):
        self.write("src/mesh/few.cpp", "/// Of the planes.\n/// Planes of the patch.\n")
        self.assertEqual(self.run_check("check_words.py")[0], 0)
        self.write("src/mesh/many.cpp", "  /// What the planes have.\n" + "int a;  ///< Of the patch.\n" * 600)
        self.assert_finds("check_words.py", "602 doc lines begin without a noun")

    def test_words_finds_texts_that_stand_in_two_files_beyond_the_budget(self):
        texts = "".join(f'say("the surface number {i} has "\n    "no triangles");  // "\n' for i in range(60))
        self.write("src/mesh/one.cpp", texts)
        self.assertEqual(self.run_check("check_words.py")[0], 0)
        self.write("apps/lumesh/other.cpp", texts)
        self.assert_finds("check_words.py", "60 texts stand in two files")
        self.assert_finds("check_words.py", "apps/lumesh/other.cpp, src/mesh/one.cpp: \"the surface number 7 has no triangles\"")

    def test_words_finds_numbers_of_defaults_in_texts(self):
        self.write("src/mesh/good.cpp", 'list.number("a", a, above(2), "Of 3 parts").in("mm").zero(fmt::format("{:.2g} voxels", kUsual), 1e9);\n'
                   'list.number("b", b, "Default: auto; 0: none").by_default("as the sources say");\n')
        self.assertEqual(self.run_check("check_words.py")[0], 0, self.run_check("check_words.py")[1])
        for text, said in (('.zero("2.5 voxels")', "2.5 voxels"), ('.by_default(fmt::format("{} of 3 (or {})", f(")"), 2))', "{} of 3 (or {})"),
                           ('.zero("none of " "a quarter")', "none of a quarter"), ('"Radius; default 14, of " "others 9"', "Radius; default 14, of others 9")):
            self.write("src/mesh/bad.cpp", f'list.number("c", c, "C"){text if text[0] == "." else "," + text};\n')
            self.assert_finds("check_words.py", f'src/mesh/bad.cpp: "{said}" has the number of a default')

    def test_words_finds_options_that_are_described_twice(self):
        self.write("src/mesh/one.cpp", 'list.number("time_limit", t, above(0), "Time");\nlist.flag("feature_angle", a, "A");\n')
        self.write("apps/lumesh/two.cpp", 'sub->add_option("-o,--file", f, "F");\nsub->add_flag("--time-limit", t, meaning_of(Keys(), "time_limit"));\n'
                   'list.flag("feature_angle", b, "B");\n')
        self.assertEqual(self.run_check("check_words.py")[0], 0, self.run_check("check_words.py")[1])
        self.write("apps/lumesh/three.cpp", 'sub->add_option_function<std::vector<std::string>>(\n    "-t,--time-limit", set, "Stop then");\n')
        self.assert_finds("check_words.py", "option time_limit is described 2 times (apps/lumesh/three.cpp, src/mesh/one.cpp), 1 may")
        self.write("apps/lumesh/three.cpp", 'list.number("feature_angle", c, "C");\n')
        self.assert_finds("check_words.py", "option feature_angle is described 3 times (apps/lumesh/three.cpp, apps/lumesh/two.cpp, src/mesh/one.cpp), 2 may")
        self.write("apps/lumesh/two.cpp", "")
        self.write("apps/lumesh/three.cpp", "")
        self.assert_finds("check_words.py", "option feature_angle is described 1 times")

    def test_option_tables_finds_meanings_under_two_names(self):
        sections = {"a": [{"name": name, "meaning": f"about {name}"} for name in ("x", "y")], "b": [{"name": "x", "meaning": "about x"}]}
        for names in option_tables.SHARED_MEANINGS: sections["b"] += [{"name": name, "meaning": str(names)} for name in names]
        self.assertEqual(list(option_tables.faults_of_meanings(sections)), [])
        sections["b"].append({"name": "z", "meaning": "about y"})
        self.assertEqual(list(option_tables.faults_of_meanings(sections)), ['"about y" is the meaning of y and z; make them one option'])
        self.assertIn("size share no meaning any more", " ".join(option_tables.faults_of_meanings({"a": sections["a"]})))

    def test_words_finds_pages_without_sources_or_picture(self):
        self.write("docs/images/a.png", "")
        self.write("docs/stages/a.md", "# a\n\n![A](../images/a.png)\n\n## Limits\n\n## Sources\n")
        self.assertEqual(self.run_check("check_words.py")[0], 0)
        self.write("docs/stages/b.md", "# b\n\n![B](../images/b.png)\n")
        self.assert_finds("check_words.py", "docs/stages/b.md: no heading '## Sources'")
        self.assert_finds("check_words.py", "docs/stages/b.md: no heading '## Limits'")
        self.assert_finds("check_words.py", "docs/stages/b.md: the picture ../images/b.png is not there")
        self.write("docs/stages/b.md", "# b\n\n## Sources\n")
        self.assert_finds("check_words.py", "docs/stages/b.md: no picture")

    def test_test_patterns_finds_patterns_and_folders_that_no_test_has(self):
        self.write("tests/unit/mesh/a_test.cpp", "TEST(Mesh, IsWhole) {}\nTEST_P(MeshOnThreads, IsTheSame) {}\n"
                   "INSTANTIATE_TEST_SUITE_P(\n    Threads, MeshOnThreads, testing::Values(1));\n")
        tests = "set(LUMESH_THREAD_TESTS test_mesh)\nset(LUMESH_NOT_SANITIZED\n    Mesh.IsW*\n    */MeshOnThreads.*)\nset(LUMESH_NOT_ASAN Mesh.?sWhole)\n" \
                "set(LUMESH_NOT_TSAN Mesh.Is?hole)\n"
        self.write("tests/CMakeLists.txt", tests)
        self.assertEqual(self.run_check("check_test_patterns.py")[0], 0, self.run_check("check_test_patterns.py")[1])
        for old, new, words in (("Mesh.IsW*", "Mesh.WasWhole*", "LUMESH_NOT_SANITIZED: no test has a name like Mesh.WasWhole*"),
                                ("*/MeshOn", "MeshOn", "no test has a name like MeshOnThreads.*"),
                                ("?sWhole", "IsHalf", "LUMESH_NOT_ASAN: no test has a name like Mesh.IsHalf"),
                                ("set(LUMESH_NOT_ASAN Mesh.?sWhole)", "", "LUMESH_NOT_ASAN has no pattern"),
                                ("test_mesh", "test_net", "test_net has no folder tests/unit/net")):
            self.write("tests/CMakeLists.txt", tests.replace(old, new))
            self.assert_finds("check_test_patterns.py", words)

    def test_option_tables_finds_flags_without_a_page_and_rows_without_a_flag(self):
        helps = "Options:\n  -o,--output TEXT REQUIRED   Mesh\n  --json [FILE]               Numbers\n                              --no-flag\n"
        common = "| `-o FILE`, `--output FILE` |\n"
        page = "# mesh\n\n## Options\n\n[All](../options.md).\n\n| `--json [FILE]` | off | As `lumesh x --y` |\n\n## Else\n\n| `--z` |\n"

        def faults(text, common=common):
            return list(option_tables.faults_of_page("mesh", helps, text, common))

        self.assertEqual(faults(page), [])
        self.assertIn("--output stands neither here", faults(page, "`--output-all`, `-o FILE`")[0])
        self.assertIn("--json stands neither here", faults(page.replace("--json [FILE]", "FILE"))[0])
        self.assertIn("has no link to docs/options.md", faults(page.replace("../options.md", "all.md"))[0])
        self.assertIn("a file may be left out", faults(page.replace("[FILE]", "FILE"))[0])
        self.assertIn("has no option --fine", faults(page.replace("| `--json", "| `--fine`, `-o F` | |\n| `--json"))[0])

    def test_option_tables_takes_a_part_of_a_section(self):
        options = [{"name": name} for name in "abcd"]
        self.assertEqual(option_tables.part_of(options, "b", "c"), options[1:3])
        self.assertEqual(option_tables.part_of(options, None, None), options)
        match = option_tables.BLOCK.search("<!-- options input from b to c -->\n| x |\n<!-- end of options -->")
        self.assertEqual(match.groups()[1:4], ("input", "b", "c"))

    def test_option_tables_finds_formats_without_a_row_and_lists_of_no_use(self):
        formats = {"read": [".vtu", ".vtk", ".vtk.gz", ".stl"], "read volume": [".vtu", ".vtk", ".vtk.gz"],
                   "write": [".vtu", ".foam for OpenFOAM", "a folder NAME-mesh for X"]}
        page = "| File | Read |\n|---|---|\n| `.vtu` | `.x` |\n| `.vtk` | also `.vtk.gz` |\n| `.foam`, `NAME-mesh` | – |\n"

        def faults(text, wanted=("read volume", "write")):
            return list(option_tables.faults_of_format_table("p", text, "| File |", [one for use in wanted for one in formats[use]]))

        self.assertEqual(faults(page), [])
        self.assertEqual(faults(page, ("read", "write")), ["p: its table of formats has no row of .stl"])
        self.assertEqual(faults(page.replace("`.vtu`", "`.vtx`"))[1:], ["p: its table of formats has a row of .vtx, which is none"])
        self.assertEqual(len(faults("no table")), 4)
        for row, count in (("| `-o` | `.vtu`, `.vtk`; also `.stl` |", 0), ("| `FROM` | `.vtu`, `.stl` |", 1), ("| `x` | `.vtu`, `.stl` |", 0)):
            self.assertEqual(len(list(option_tables.faults_of_lists("p", row, formats))), count, row)

    def test_sizes_finds_a_long_function(self):
        self.write("src/mesh/bad.cpp", "int long_one(int a) {\n" + "  a += 1;\n" * 90 + "  return a;\n}\n")
        self.assert_finds("check_sizes.py", "long_one has 93 lines, limit 80")

    def test_sizes_finds_a_long_constructor_with_a_brace_initialiser(self):
        self.write("src/mesh/bad.cpp", "Mesh::Mesh(int a)\n    : a_{a}, b_(2) {\n" + "  ++a;\n" * 90 + "}\n")
        self.assert_finds("check_sizes.py", "Mesh::Mesh has 93 lines, limit 80")

    def test_sizes_finds_a_long_method_inside_a_class_template(self):
        self.write("src/mesh/bad.cpp", "template <class T>\nclass Box {\n public:\n  template <class U>\n  auto grow(U u) const"
                   " -> T {\n" + "    ++u;\n" * 90 + "  }\n};\n")
        self.assert_finds("check_sizes.py", "grow has 93 lines, limit 80")

    def test_sizes_finds_a_complex_function(self):
        self.write("src/mesh/bad.cpp", "int maze(int a) {\n" + "  if (a > 1 && a < 2) ++a;\n" * 10 + "  return a;\n}\n")
        self.assert_finds("check_sizes.py", "maze has complexity 21, limit 20")

    def test_sizes_finds_a_long_header_and_a_long_source(self):
        self.write("include/lumesh/core/long.hpp", "int a();\n" * 401)
        self.write("src/core/long.cpp", "int a();\n" * 801)
        self.assert_finds("check_sizes.py", "include/lumesh/core/long.hpp has 401 lines, limit 400")
        self.assert_finds("check_sizes.py", "src/core/long.cpp has 801 lines, limit 800")

    def test_sizes_finds_a_command_that_does_more_than_parse_call_and_print(self):
        for name, lines in (("lattice.cpp", 81), ("adapt.cpp", 80), ("common.cpp", 81), ("usual.hpp", 81)):
            self.write(f"apps/lumesh/{name}", "int a();\n" * lines)
        self.assert_finds("check_sizes.py", "apps/lumesh/lattice.cpp has 81 lines, limit 80 of a command")
        self.assertIn("; 1 faults", self.run_check("check_sizes.py")[1])

    def test_sizes_does_not_take_a_table_or_a_namespace_for_a_function(self):
        self.write("src/mesh/good.cpp", "namespace lumesh {\nconstexpr int kTable[] = {\n" + "  f(1),\n" * 90 + "};\n"
                   + "int one() { return 1; }\n" * 90 + "}\n")
        self.assertEqual(self.run_check("check_sizes.py")[0], 0, self.run_check("check_sizes.py")[1])

    def test_sizes_accepts_an_exception_with_a_reason_and_refuses_a_stale_one(self):
        self.write("src/mesh/bad.cpp", "int table() {\n" + "  g();\n" * 90 + "}\n")
        self.write("scripts/size_exceptions.txt", "src/mesh/bad.cpp:table generated code\n")
        self.assertEqual(self.run_check("check_sizes.py")[0], 0)
        self.write("scripts/size_exceptions.txt", "src/mesh/gone.cpp:table generated code\n")
        self.assert_finds("check_sizes.py", "needs no exception any more")


if __name__ == "__main__":
    unittest.main()
