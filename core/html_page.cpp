// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/html_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/html_name.h"
#include "core/plot.h"
#include "core/text.h"

namespace thermotwin::core {
namespace {

const char* const style = R"(
:root { --ink:#1c2430; --soft:#5b6675; --line:#dde2e8; --page:#f6f7f9; --card:#fff; --point:#1b6ca8; --good:#1d7a46;
  --warn:#a15c00; }
@media (prefers-color-scheme: dark) { :root { --ink:#e6eaf0; --soft:#9aa6b5; --line:#313a46; --page:#14181e;
  --card:#1c222a; --point:#6bb3e8; --good:#5cc48a; --warn:#e5a84b; } }
* { box-sizing:border-box } body { margin:0; background:var(--page); color:var(--ink);
  font:15px/1.5 system-ui,"Segoe UI","DejaVu Sans",sans-serif }
main { max-width:1180px; margin:0 auto; padding:28px 20px 60px } h1 { font-size:22px; margin:0 } h2 {
  font-size:17px; margin:36px 0 10px } a { color:var(--point) }
.sub { color:var(--soft); margin:2px 0 18px } .card { background:var(--card); border:1px solid var(--line);
  border-radius:8px; padding:16px 18px } .card .sub:first-child { margin-bottom:12px }
.verdict { border-left:5px solid var(--soft) } .verdict.explained,.verdict.good { border-left-color:var(--good) }
  .verdict.ambiguous,.verdict.unexplained,.verdict.warn { border-left-color:var(--warn) }
.verdict b { display:block; font-size:13px; letter-spacing:.04em; text-transform:uppercase; color:var(--soft) }
  .verdict p { margin:4px 0 0; font-size:17px } .verdict .warning { margin-top:8px; font-size:14px;
  color:var(--warn) }
.tiles { display:grid; grid-template-columns:repeat(auto-fit,minmax(165px,1fr)); gap:12px; margin-top:12px }
  .tile span { color:var(--soft); font-size:13px; display:block } .tile strong .bad { color:#b3261e; display:inline;
  font-size:inherit } .tile strong { font-size:22px; font-weight:600; display:block; overflow-wrap:anywhere;
  line-height:1.3; font-variant-numeric:tabular-nums }
.scroll { overflow-x:auto } table { border-collapse:collapse; width:100%; font-variant-numeric:tabular-nums } th {
  text-align:left; vertical-align:bottom; line-height:1.3; color:var(--soft); font-weight:500; font-size:13px }
  th,td { padding:5px 10px 5px 0; border-bottom:1px solid var(--line) } td { white-space:nowrap } td:not(.n) {
  white-space:normal; overflow-wrap:break-word; min-width:84px } td.w { min-width:200px } td.n,th.n {
  text-align:right; padding-right:18px } td.n:last-child,th.n:last-child { padding-right:0 }
tr:last-child td { border-bottom:0 } .bar { display:inline-block; width:110px; height:9px; border-radius:3px;
  background:var(--line); vertical-align:middle; margin-right:8px } .bar i { display:block; height:100%;
  border-radius:3px; background:currentColor }
tr.quiet td { color:var(--soft) } .plots { display:grid;
  grid-template-columns:repeat(auto-fill,minmax(min(100%,430px),1fr)); gap:14px } figure { margin:0;
  padding:12px 14px 8px } figcaption { display:flex; justify-content:space-between; gap:10px; font-weight:600;
  font-size:14px; margin-bottom:4px } figcaption span { color:var(--soft); font-weight:400; font-size:13px }
svg { width:100%; height:auto; display:block }
.legend { display:flex; flex-wrap:wrap; gap:6px 22px; color:var(--soft); font-size:13px; margin:0 0 12px }
  .legend i { display:inline-block; width:20px; height:0; border-top:3px solid; vertical-align:middle;
  margin-right:7px } .legend i.band { height:12px; border:0; background:currentColor } canvas { width:100%;
  height:auto; display:block; touch-action:none; cursor:grab } .legend i.m { height:12px; border:0;
  background:#e8622c } .legend i.shade { height:12px; border:1px solid var(--line); background:currentColor }
pre { margin:0; overflow-x:auto; font:13px/1.55 ui-monospace,"DejaVu Sans Mono",monospace } ul,ol { margin:0;
  padding-left:20px } li { margin:3px 0 }
.controls { display:flex; flex-wrap:wrap; gap:8px 18px; align-items:center; margin:0 0 12px } .controls label {
  min-width:0; max-width:100%; color:var(--soft); font-size:13px; display:flex; gap:7px; align-items:center }
  .controls input[type=range] { width:200px } select,button { font:inherit; font-size:14px; color:var(--ink);
  background:var(--page); border:1px solid var(--line); border-radius:6px; padding:3px 8px; min-width:0;
  max-width:100% }
.next pre { background:var(--page); border:1px solid var(--line); border-radius:6px; padding:7px 10px;
  margin:4px 0 10px; white-space:pre-wrap; overflow-wrap:anywhere }
details { margin-top:14px } summary { cursor:pointer; color:var(--soft); font-size:14px; margin-bottom:6px }
.card > p:first-child { margin-top:0 } .card > p:last-child { margin-bottom:0 } p.below { color:var(--soft);
  font-size:13px; margin:12px 0 0 }
@media (max-width:700px) { main { padding:18px 12px 40px } .card { padding:12px 13px } .scroll svg {
  min-width:640px } .tiles {
  grid-template-columns:repeat(auto-fit,minmax(140px,1fr)) } .tile strong { font-size:19px } }
)";

const char* const choice_script = R"JS(
(function () {
  for (const list of document.querySelectorAll("select[data-choice]")) {
    const show = () => { for (const part of document.querySelectorAll("[data-of='" + list.id + "']")) part.hidden =
      part.dataset.name !== list.value; };
    list.addEventListener("change", show);
    show();
  }
})();
)JS";

/// Digits with a sign, point, percent or unit of a cell that stands for a number.
bool is_number(const std::string& cell) {
  const std::string_view text = trimmed(cell);
  return !text.empty() && text.find_first_of("0123456789") != std::string_view::npos &&
         text.find_first_not_of("0123456789+-.e%/ ()") == std::string_view::npos;
}

std::string table_row(const std::vector<std::string>& row, const std::vector<char>& right, const char* tag) {
  std::string markup = "<tr>";
  for (std::size_t c = 0; c < row.size(); ++c) {
    const bool number = c < right.size() && right[c] != 0;
    markup += fmt::format("<{}{}>{}</{}>", tag,
                          number               ? " class=\"n\""
                          : row[c].size() > 32 ? " class=\"w\""
                                               : "",
                          number ? html_sentence(row[c]) : breakable(html_sentence(row[c])), tag);
  }
  return markup + "</tr>\n";
}

}  // namespace

std::string html_document(std::string_view title, std::string_view body_markup) {
  std::string page =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width,initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\"><title>" +
      xml_text(title) + "</title><style>" + style + plot_style() + "</style></head><body><main>\n";
  page += body_markup;
  if (body_markup.find("data-choice") != std::string_view::npos)
    page += std::string("<script>") + choice_script + "</script>\n";
  return page + "</main></body></html>\n";
}

std::string html_sentence(std::string_view words) {
  std::string text = xml_text(words);
  const auto replace = [&](const std::string& old, const std::string& with) {
    for (auto at = text.find(old); at != std::string::npos; at = text.find(old, at + with.size()))
      text.replace(at, old.size(), with);
  };
  replace("+-", "±");
  constexpr std::pair<std::string_view, std::string_view> units[] = {{"um", "µm"}, {"degC", "°C"}, {"W/m2", "W/m²"}};
  for (const auto& [plain, sign] : units) {
    for (auto at = text.find(plain); at != std::string::npos; at = text.find(plain, at + sign.size())) {
      const auto end = at + plain.size();
      const bool ends = end == text.size() || std::string_view(" ,.;:)/").find(text[end]) != std::string_view::npos;
      if (at > 0 && text[at - 1] == ' ' && ends) text.replace(at, plain.size(), sign);
    }
  }
  return text;
}

std::string html_title(std::string_view title, std::string_view below) {
  return "<h1>" + xml_text(title) + "</h1>\n<p class=\"sub\">" + xml_text(below) + "</p>\n";
}

std::string html_tile(std::string_view label_markup, std::string_view value_markup, std::string_view below_markup) {
  return fmt::format("<div class=\"card tile\"><span>{}</span><strong>{}</strong><span>{}</span></div>\n", label_markup,
                     value_markup, below_markup);
}

std::string html_tiles(const std::vector<std::string>& tiles) {
  return "<div class=\"tiles\">\n" + join(tiles, "") + "</div>\n";
}

std::string html_finding(Tone tone, std::string_view label, const std::vector<std::string>& sentences_markup) {
  constexpr const char* classes[] = {"", " good", " warn"};
  std::string markup =
      fmt::format("<section class=\"card verdict{}\"><b>{}</b>", classes[static_cast<int>(tone)], xml_text(label));
  for (const std::string& sentence : sentences_markup) markup += "<p>" + sentence + "</p>";
  return markup + "</section>\n";
}

std::string html_section(std::string_view heading, std::string_view below_markup, std::string_view content_markup) {
  std::string markup = "<h2>" + xml_text(heading) + "</h2>\n<section class=\"card scroll\">";
  if (!below_markup.empty()) markup += fmt::format("<p class=\"sub\">{}</p>", below_markup);
  return markup + "\n" + std::string(content_markup) + "</section>\n";
}

std::string html_wide(int most_px, std::string_view picture_markup) {
  return fmt::format("<div style=\"max-width:{}px\">\n{}</div>\n", most_px, picture_markup);
}

std::string html_figure(std::string_view caption, std::string_view note, std::string_view picture_markup) {
  return fmt::format("<figure class=\"card\"><figcaption>{}<span>{}</span></figcaption>\n{}</figure>\n",
                     xml_text(caption), xml_text(note), picture_markup);
}

std::string html_figures(const std::vector<std::string>& figures) {
  return "<div class=\"plots\">\n" + join(figures, "") + "</div>\n";
}

std::string html_table(const std::vector<std::vector<std::string>>& rows) {
  if (rows.empty()) return "";
  std::vector<char> right(rows.front().size(), 0);
  for (std::size_t c = 0; c < right.size(); ++c) {
    bool any = false, all = true;
    for (std::size_t r = 1; r < rows.size(); ++r) {
      if (c >= rows[r].size() || rows[r][c].empty() || rows[r][c] == "-") continue;
      any = true;
      all = all && is_number(rows[r][c]);
    }
    right[c] = any && all ? 1 : 0;
  }
  std::string markup = "<table>\n" + table_row(rows.front(), right, "th");
  for (std::size_t r = 1; r < rows.size(); ++r) markup += table_row(rows[r], right, "td");
  return markup + "</table>\n";
}

std::string html_choice(std::string_view id, std::string_view label,
                        const std::vector<std::pair<std::string, std::string>>& items) {
  std::string options, contents;
  for (const auto& [name, markup] : items) {
    options += fmt::format("<option value=\"{0}\">{0}</option>", xml_text(name));
    contents += fmt::format("<div data-of=\"{}\" data-name=\"{}\">{}</div>\n", id, xml_text(name), markup);
  }
  return fmt::format("<div class=\"controls\"><label>{} <select id=\"{}\" data-choice>{}</select></label></div>\n{}",
                     xml_text(label), id, options, contents);
}

std::string html_next_steps(const std::vector<NextStep>& steps) {
  std::string markup = "<ol class=\"next\">\n";
  for (const NextStep& step : steps)
    markup += "<li>" + xml_text(step.why) + "<pre>" + xml_text(step.command) + "</pre></li>\n";
  return html_section("What to do next", "", markup + "</ol>\n");
}

}  // namespace thermotwin::core
