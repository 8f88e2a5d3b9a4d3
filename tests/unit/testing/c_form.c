/* A thread module in C. A second instance must not share its variables. */
#include <takt/module.h>

#include <basic_c.h>

TAKT_IN_PORT(basic_Number, in);
TAKT_OUT_PORT(basic_Number, out);

static double sum = 0;

void run(void);
void recover(void);
void run(void) {
  basic_Number number;
  if (takt_read(&in, &number)) sum += number.value;
  if (sum > 100) takt_log(TAKT_LOG_WARNING, "the sum is %.1f", sum);
  if (sum < 0) takt_fail("the sum is negative");
  if (sum > 1000) takt_finish();
  number.value = sum + (double)takt_cycle();
  takt_write(&out, &number);
}
void recover(void) { sum = 0; }
