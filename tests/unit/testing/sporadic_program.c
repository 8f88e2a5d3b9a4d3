/* A program like the paper's Figure 11. Its body runs at every third release, and when an order arrives. */
#include <takt/process.h>

#include <basic_c.h>

TAKT_EVENT_PORT(basic_Count, order);
TAKT_OUT_PORT(basic_Count, bodies);
TAKT_INTEGER(step, 1, 1, 100, "", "What a body adds if it was not ordered.");

static int releases = 0;

static int condition(void) {
  waitSporadic();
  return ++releases % 3 == 0 || takt_has_news(&order) ? TRUE : FALSE;
}

int main(void) {
  basic_Count count = {0};
  basic_Count ordered;
  initSporadicExe();
  while (1) {
    if (!condition()) continue;
    count.value += takt_read(&order, &ordered) ? ordered.value : step;
    takt_write(&bodies, &count);
  }
}
