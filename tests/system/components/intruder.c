/* A component that an attacker puts in the place of another one. When it is loaded, it creates the file that
 * TAKT_INTRUDER names. */
#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

__attribute__((constructor)) static void intrude(void) {
  const char* path = getenv("TAKT_INTRUDER");
  if (path != NULL) close(open(path, O_CREAT | O_WRONLY | O_CLOEXEC, 0644));
}

void run(void);
void run(void) {}
