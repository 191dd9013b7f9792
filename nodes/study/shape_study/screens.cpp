#include "nodes/study/shape_study/screens.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <utility>

#include "graph/diagnostic.h"
#include "nodes/data/indices.h"
#include "runtime/random.h"

namespace terrazzo::shape_study {

namespace {

int original_of(const std::vector<Stimulus>& stimuli, const std::string& shape) {
  for (std::size_t i = 0; i < stimuli.size(); ++i)
    if (stimuli[i].shape == shape && stimuli[i].method == "original") return i;
  return -1;
}

// A random screen with a decoy from stimulus i, or without one if that is the original. All sections have
// different numbers, so that even stacks cut by the same planes show no plane twice.
Screen draw_screen(const std::vector<Stimulus>& stimuli, std::size_t i, Random r) {
  const int original = original_of(stimuli, stimuli[i].shape);
  const std::uint64_t n = stimuli[original].sections;
  const int a = r.below(n);
  int b = r.below(n - 1);
  b += b >= a;
  std::vector<int> left_over;
  for (int k = 0; k < stimuli[i].sections; ++k)
    if (k != a && k != b) left_over.push_back(k);
  Screen s;
  s.shape = stimuli[i].shape;
  s.method = stimuli[i].method;
  s.center = {original, a};
  const Screen::Shown same{original, b};
  const Screen::Shown other{static_cast<int>(i), left_over[r.below(left_over.size())]};
  const bool left = r.below(2) == 0;
  s.decoy = static_cast<int>(i) == original ? "none" : left ? "left" : "right";
  s.left = left ? other : same;
  s.right = left ? same : other;
  return s;
}

using Images = std::array<std::pair<int, int>, 3>;

// The images of a screen, wherever they are on it.
Images images_of(const Screen& s) {
  Images out{{{s.left.stimulus, s.left.section},
              {s.center.stimulus, s.center.section},
              {s.right.stimulus, s.right.section}}};
  std::sort(out.begin(), out.end());
  return out;
}

std::string image_list(const std::vector<Screen>& screens,
                       const std::vector<std::vector<std::string>>& names) {
  const auto name = [&](const Screen::Shown& s) { return names[s.stimulus][s.section]; };
  std::string list;
  for (std::size_t i = 0; i < screens.size(); ++i)
    list += fmt::format("[{},\"{}\",\"{}\",\"{}\"],\n", i + 1, name(screens[i].left), name(screens[i].center),
                        name(screens[i].right));
  return list;
}

}  // namespace

std::vector<Screen> make_screens(const std::vector<Stimulus>& stimuli, int repeats, std::uint64_t seed) {
  std::vector<Screen> out;
  std::uint64_t item = 0;
  std::vector<std::string> shapes;
  for (const auto& s : stimuli)
    if (std::find(shapes.begin(), shapes.end(), s.shape) == shapes.end()) shapes.push_back(s.shape);
  for (const auto& shape : shapes) {
    const int original = original_of(stimuli, shape);
    if (original < 0 || stimuli[original].sections < 3)
      throw Error("no-original", fmt::format("'{}' needs at least three sections of its original", shape),
                  "name a stack of three sections or more '" + shape + "/original'");
    for (std::size_t i = 0; i < stimuli.size(); ++i) {
      if (stimuli[i].shape != shape) continue;
      if (stimuli[i].sections < 3)
        throw Error("too-few-sections",
                    fmt::format("the stack {}/{} has {} sections, but needs three", shape, stimuli[i].method,
                                stimuli[i].sections),
                    "add sections to that stack");
      for (int k = 0; k < repeats; ++k) out.push_back(draw_screen(stimuli, i, Random(seed, 301, item++)));
    }
  }
  return out;
}

std::vector<Screen> make_training(const std::vector<Stimulus>& stimuli, const std::vector<Screen>& test,
                                  int count, std::uint64_t seed) {
  constexpr int kTries = 64;  // per stack; a stack with any fresh screen left is rarely missed
  std::set<Images> taken;
  for (const Screen& s : test) taken.insert(images_of(s));
  std::vector<std::size_t> order(stimuli.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random shuffle(seed, 303);
  for (std::size_t k = order.size(); k > 1; --k) std::swap(order[k - 1], order[shuffle.below(k)]);
  std::vector<Screen> out;
  std::uint64_t item = 0;
  std::size_t at = 0;
  while (count_of(out) < count) {
    const std::size_t before = out.size();
    for (std::size_t k = 0; k < order.size() && out.size() == before; ++k)
      for (int i = 0; i < kTries && out.size() == before; ++i) {
        Screen s = draw_screen(stimuli, order[(at + k) % order.size()], Random(seed, 304, item++));
        if (taken.insert(images_of(s)).second) out.push_back(std::move(s));
      }
    if (out.size() == before)
      throw Error("too-few-sections",
                  fmt::format("{} training screens are requested, but only {} have other images than all "
                              "{} test screens",
                              count, before, test.size()),
                  "add sections to the stacks, or lower training or repeats")
          .parameter("training");
    ++at;
  }
  return out;
}

Table key_of(const std::vector<Screen>& screens, const std::vector<std::vector<std::string>>& names) {
  Table t;
  t.columns = {"screen", "shape", "method", "decoy", "left", "center", "right"};
  const auto name = [&](const Screen::Shown& s) { return names[s.stimulus][s.section]; };
  for (std::size_t i = 0; i < screens.size(); ++i) {
    const Screen& s = screens[i];
    t.rows.push_back({static_cast<double>(i + 1), s.shape, s.method, s.decoy, name(s.left), name(s.center),
                      name(s.right)});
  }
  return t;
}

std::string page_of(const std::vector<Screen>& screens, const std::vector<Screen>& training,
                    const std::vector<std::vector<std::string>>& names) {
  std::string page = R"html(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Which one is least similar?</title><style>
body{background:#808080;color:#000;font:18px/1.5 sans-serif;margin:0;display:flex;min-height:100vh;align-items:center;justify-content:center}
#row{display:flex;gap:40px}#row img{width:250px;height:250px;display:block}#row img.side{cursor:pointer}
#text{max-width:640px}button{font:inherit;padding:.3em 1.2em}textarea{width:100%;height:12em}input{font:inherit}
</style></head><body><div id="text">
<p>You will see three images in a row: sections through a material of black grains. Click the outer image that is
<b>least like the middle one</b>. Judge by the <b>shapes</b> of the grains, not by their sizes, number or positions.</p>
<p>Participation is voluntary, and no data leave this computer. The first screens are for practice.</p>
<p>A name for this session: <input id="who" value="1"> <button id="go">Begin</button></p></div>
<div id="row" hidden></div><script>
const practice=[
@TRAINING@],training=practice.length,screens=[
@SCREENS@];
const text=document.getElementById("text"),row=document.getElementById("row");
function shuffled(a){a=a.slice();for(let i=a.length-1;i>0;--i){const j=Math.floor(Math.random()*(i+1));[a[i],a[j]]=[a[j],a[i]];}return a;}
let who="",queue=[],at=0,shown=0,open=false;const answers=[];
function next(){
  open=false;row.hidden=true;
  if(at===queue.length)return done();
  if(at===training){text.hidden=false;text.innerHTML="<p>Now the test begins.</p><p><button>Continue</button></p>";
    text.querySelector("button").onclick=()=>{text.hidden=true;show();};return;}
  setTimeout(show,1000);
}
function show(){
  row.innerHTML="";
  const names=queue[at].slice(1);let left=3;
  names.forEach((n,i)=>{const p=new Image();p.src="images/"+n;p.alt="";p.draggable=false;
    p.onload=p.onerror=()=>{if(--left===0){row.hidden=false;shown=performance.now();open=true;}};
    if(i!==1){p.className="side";p.onclick=()=>choose(i===0?"left":"right");}row.appendChild(p);});
}
function choose(side){
  if(!open)return;
  if(at>=training)answers.push([who,queue[at][0],side,((performance.now()-shown)/1000).toFixed(3)]);
  ++at;next();
}
function done(){
  const csv="participant,screen,choice,seconds\n"+answers.map(a=>a.join(",")).join("\n")+"\n";
  text.hidden=false;text.innerHTML="<p>Done, thank you. Please save the answers.</p><p><a download='answers.csv'><button>Save answers.csv</button></a></p><textarea readonly></textarea>";
  text.querySelector("textarea").value=csv;
  text.querySelector("a").href=URL.createObjectURL(new Blob([csv],{type:"text/csv"}));
}
document.getElementById("go").onclick=()=>{
  who=document.getElementById("who").value.replace(/[^\w.-]/g,"_")||"1";
  queue=shuffled(practice).concat(shuffled(screens));at=0;text.hidden=true;
  if(training===0)show();else{setTimeout(show,1000);}
};
</script></body></html>
)html";
  page.replace(page.find("@TRAINING@"), 10, image_list(training, names));
  page.replace(page.find("@SCREENS@"), 9, image_list(screens, names));
  return page;
}

}  // namespace terrazzo::shape_study
