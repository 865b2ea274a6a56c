#!/bin/sh
# Opens a report in a real headless browser: no console message, every picture decoded, every plot drawn.
# Usage: scripts/check_report.sh REPORT.html SCREENSHOT.png     Exit: 0 good, 1 fault, 77 no browser here (skipped).
set -eu

report=$1
screenshot=$2
browser=$(command -v chromium || command -v chromium-browser || true)
if [ -z "$browser" ]; then
  echo "check_report: skipped, chromium is not installed (apt-get install chromium)"
  exit 77
fi
if grep -qE '(src|href)="(https?:)?//|@import|url\(' "$report"; then
  echo "check_report: $report refers to the network"
  exit 1
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
browse() {
  timeout 120 "$browser" --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking \
    --disable-component-update --disable-sync --hide-scrollbars --user-data-dir="$work/profile" \
    --enable-logging=stderr "$@" 2>>"$work/log"
}

# The report has no script of its own; a copy gets one that says what the browser made of the page.
cp "$report" "$work/page.html"
cat >>"$work/page.html" <<'END'
<script>
addEventListener("load", () => {
  const images = [...document.images], plots = [...document.querySelectorAll("svg")];
  const decoded = images.filter(i => i.complete && i.naturalWidth > 0).length;
  const drawn = plots.filter(p => p.querySelectorAll("rect, path, .none").length > 0 && p.getBoundingClientRect().height > 50).length;
  const wide = document.documentElement.scrollWidth > innerWidth;
  document.body.insertAdjacentHTML("beforeend",
    `<p id="check">images ${decoded}/${images.length} plots ${drawn}/${plots.length} overflow ${wide}</p>`);
});
</script>
END
browse --window-size=1200,900 --dump-dom "file://$work/page.html" >"$work/dom.html"
status=$(grep -o '<p id="check">images [0-9][^<]*' "$work/dom.html" | sed 's/.*>//' || true)
echo "check_report: ${status:-the page did not load}"
# Pictures and plots, each "so many good of so many".
counts=$(echo "$status" | sed -nE 's|^images ([0-9]+)/([0-9]+) plots ([0-9]+)/([0-9]+) overflow false$|\1 \2 \3 \4|p')
# shellcheck disable=SC2086
set -- ${counts:-0 1 0 1}
if [ "$1" -ne "$2" ] || [ "$3" -ne "$4" ] || [ "$1" -lt 1 ] || [ "$3" -lt 1 ]; then exit 1; fi
if grep "CONSOLE" "$work/log"; then
  echo "check_report: the page writes to the console"
  exit 1
fi
case $report in /*) ;; *) report=$(pwd)/$report ;; esac
browse --window-size=1200,2900 --screenshot="$screenshot" "file://$report"
if [ ! -s "$screenshot" ]; then
  echo "check_report: no screenshot came out"
  exit 1
fi
