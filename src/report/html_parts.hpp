#pragma once
/// @file Pieces of the pages. Texts are HTML unless said otherwise.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "lumesh/report/picture.hpp"

namespace lumesh::report {

/// Text with <, >, &, and quotes made harmless.
[[nodiscard]] std::string escaped(std::string_view text);

/// Head of a row of tables.
inline constexpr const char* kMeanRatioRow = "mean ratio, average and worst";

/// From the first line of the file to the begin of what is to be read; both arguments are plain text.
[[nodiscard]] std::string page_begin(const std::string& title, const std::string& kind);
[[nodiscard]] std::string page_end();

/// A card with a heading.
[[nodiscard]] std::string section(const std::string& title, const std::string& content);
/// Side by side where there is room.
[[nodiscard]] std::string pair(const std::string& left, const std::string& right);
/// A number in large letters, and what it is.
[[nodiscard]] std::string tile(const std::string& value, const std::string& name);
[[nodiscard]] std::string plot_html(const std::string& caption, const std::string& svg);

/// @param description  Plain text, for those who cannot see it.
[[nodiscard]] std::string image_tag(const Picture& picture, const std::string& description);
/// With names over it as text, in the colours of the page.
[[nodiscard]] std::string image_tag(const Picture& picture, const PictureLabels& names,
                                    const std::string& description);
[[nodiscard]] std::string legend_html(const std::vector<LegendItem>& legend);
[[nodiscard]] std::string scale_html(const ColourScale& scale);

/// Cards with plain texts; nothing where there are none.
[[nodiscard]] std::string warnings_html(const std::vector<std::string>& warnings);
[[nodiscard]] std::string provenance_html(const std::map<std::string, std::string>& provenance);

/// Rows of cells; the first row is the head. Cells hold HTML; a cell that begins with '!' is marked as worse.
using Table = std::vector<std::vector<std::string>>;
[[nodiscard]] std::string table_html(const Table& table);

}  // namespace lumesh::report
