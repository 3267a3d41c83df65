/* Counts the instructions that watched functions execute, and models their cycles.
 *
 * A plugin of QEMU's translator. For each return of a watched function it logs
 *     cost <function> <instructions> <cycles>
 * into QEMU's log (-d plugin), in one order with the stores that -d unimp logs there.
 *
 *   qemu-system-arm -d unimp,plugin -plugin counter.so,watch=0x8001234,watch=0x8005678 ...
 *
 * Instructions are counted one by one as they are executed, so a block that QEMU starts anew after a device access is
 * not counted twice. One function is watched at a time: from its first instruction until control leaves it at call
 * depth 0, by a return or by the end of an interrupt. The step interrupt is never interrupted, so what runs in between
 * is its own.
 *
 * The cycles are a model: arithmetic 1, load 2 (1 right behind another load), store 1, multiple load or store 1 + N,
 * taken branch + 2, division 6, interrupt entry 12 and exit 12. Memory without wait states.
 *
 * Debian 12 has no header for this interface; the declarations below are those of its documentation. PLUGIN_VERSION is
 * 1 for QEMU 7.2, 4 for QEMU 10. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint64_t qemu_plugin_id_t;
typedef struct qemu_info_t qemu_info_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
enum qemu_plugin_cb_flags { QEMU_PLUGIN_CB_NO_REGS };

void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, struct qemu_plugin_tb *));
void qemu_plugin_register_vcpu_insn_exec_cb(struct qemu_plugin_insn *, void (*)(unsigned, void *),
                                            enum qemu_plugin_cb_flags, void *);
size_t qemu_plugin_tb_n_insns(const struct qemu_plugin_tb *);
struct qemu_plugin_insn *qemu_plugin_tb_get_insn(const struct qemu_plugin_tb *, size_t);
uint64_t qemu_plugin_insn_vaddr(const struct qemu_plugin_insn *);
size_t qemu_plugin_insn_size(const struct qemu_plugin_insn *);
#if PLUGIN_VERSION < 3
const void *qemu_plugin_insn_data(const struct qemu_plugin_insn *);
#else
size_t qemu_plugin_insn_data(const struct qemu_plugin_insn *, void *, size_t);
#endif
void qemu_plugin_outs(const char *);

__attribute__((visibility("default"))) int qemu_plugin_version = PLUGIN_VERSION;

enum kind { PLAIN, LOAD, BRANCH, CALL, RETURN };

struct instruction {
    uint32_t address, size;
    enum kind kind;
    uint32_t cycles;
    bool conditional; /* in an IT block */
    int watched; /* number of the watched function that begins here, or -1 */
};

#define FLASH 0x08000000u
#define FLASH_BYTES (1u << 20)
#define MOST_WATCHED 32

/* One record for each half-word of flash: a record outlives the translation that fills it. */
static struct instruction known[FLASH_BYTES / 2];
static uint32_t watched[MOST_WATCHED];
static int watched_count;

static int current = -1; /* function being counted */
static uint64_t instructions, cycles;
static int depth;
static struct instruction *last;

static uint32_t ones(uint32_t bits) { return (uint32_t)__builtin_popcount(bits); }

/* Kind and cycles of a Thumb-2 instruction; `second` is 0 for a 16-bit one. */
static void classify(struct instruction *i, uint32_t first, uint32_t second)
{
    bool wide = i->size == 4;
    i->kind = PLAIN;
    i->cycles = 1;
    if (!wide) {
        bool register_load = (first & 0xF000) == 0x5000 && (first & 0x0E00) >= 0x0600;
        bool offset_load = first >= 0x6000 && first < 0x9000 && (first & 0x0800);
        if ((first & 0xF800) == 0x4800 || register_load || offset_load || (first & 0xF800) == 0x9800)
            i->kind = LOAD, i->cycles = 2;
        else if ((first & 0xFE00) == 0xB400)                       /* push */
            i->cycles = 1 + ones(first & 0x1FF);
        else if ((first & 0xFE00) == 0xBC00)                       /* pop, perhaps into PC */
            i->cycles = 1 + ones(first & 0x1FF), i->kind = (first & 0x100) ? RETURN : PLAIN;
        else if ((first & 0xF000) == 0xC000)                       /* ldm, stm */
            i->cycles = 1 + ones(first & 0xFF);
        else if ((first & 0xFF80) == 0x4700)                       /* bx: of LR a return, else a jump */
            i->kind = (first >> 3 & 15) == 14 ? RETURN : BRANCH;
        else if ((first & 0xFF80) == 0x4780)                       /* blx */
            i->kind = CALL;
        else if (((first & 0xF000) == 0xD000 && (first & 0x0F00) < 0x0E00) || (first & 0xF800) == 0xE000 ||
                 (first & 0xF500) == 0xB100 || (first & 0xFF87) == 0x4687)
            i->kind = BRANCH;                                      /* b, cbz, cbnz, mov pc */
        return;
    }
    if ((first & 0xFE40) == 0xE800) {                              /* ldm, stm */
        bool load = first & 0x10;
        i->cycles = 1 + ones(second);
        i->kind = load && (second & 0x8000) ? RETURN : PLAIN;
    } else if ((first & 0xFE40) == 0xE840) {                       /* ldrd, strd, exclusive, table branch */
        if ((first & 0xFFF0) == 0xE8D0 && (second & 0xFFE0) == 0xF000)
            i->kind = BRANCH, i->cycles = 2;
        else if ((first & 0x0120) == 0)                            /* exclusive: one word */
            i->cycles = 2;
        else
            i->cycles = 3;
    } else if ((first & 0xF800) == 0xF000 && (second & 0x8000)) {  /* branches */
        if ((second & 0xD000) == 0xD000)
            i->kind = CALL;
        else if ((second & 0x1000) || (first & 0x0380) != 0x0380)
            i->kind = BRANCH;
    } else if ((first & 0xFE00) == 0xF800) {                       /* single load, store */
        if (first & 0x10) {
            bool to_pc = (second >> 12) == 15 && (first & 0x60) == 0x40;
            bool popped = (first & 0xF) == 13;
            i->kind = to_pc ? (popped ? RETURN : BRANCH) : LOAD;
            i->cycles = 2;
        }
    } else if ((first & 0xFFD0) == 0xFB90) {                       /* division, 2 to 12 */
        i->cycles = 6;
    } else if ((first & 0xFE00) == 0xEC00) {                       /* float load, store: one or many */
        bool multiple = (first & 0x0120) != 0x0100;
        uint32_t words = (second & 0x0100) ? 2 : 1;
        i->cycles = multiple ? 1 + (second & 0xFF) : (first & 0x10) ? 1u + words : words;
    } else if ((first & 0xFF00) == 0xEE00 && (second & 0x0E10) == 0x0A00) {
        bool long_one = (first & 0xFFB0) == 0xEE80 || ((first & 0xFFBF) == 0xEEB1 && (second & 0x00C0) == 0x00C0);
        i->cycles = long_one ? 14 : 1;                             /* float division, square root */
    }
}

static void finish(void)
{
    char line[80];
    if (current == 0) /* the interrupt: its entry and exit */
        cycles += 12 + 12;
    snprintf(line, sizeof line, "cost %d %llu %llu\n", current, (unsigned long long)instructions,
             (unsigned long long)cycles);
    qemu_plugin_outs(line);
    current = -1;
}

/* Whether `i` left the straight path to get to `next`. What follows in memory may also be where a return leads to. */
static bool jumped(const struct instruction *i, const struct instruction *next)
{
    if (i->kind == PLAIN || i->kind == LOAD)
        return false;
    return (i->kind == RETURN && !i->conditional) || next->address != i->address + i->size;
}

/* Before each instruction: settle where the last one went, then count this one. */
static void execute(unsigned cpu, void *data)
{
    struct instruction *i = data;
    (void)cpu;
    if (current >= 0 && last && jumped(last, i)) {
        if (last->kind == RETURN && depth == 0) {
            finish();
        } else {
            cycles += 2;
            depth += (last->kind == CALL) - (last->kind == RETURN);
        }
    }
    if (current < 0 && i->watched >= 0) {
        current = i->watched;
        instructions = cycles = 0;
        depth = 0;
        last = NULL;
    }
    if (current >= 0) {
        bool behind_load = last && last->kind == LOAD && i->kind == LOAD;
        instructions++;
        cycles += behind_load ? 1 : i->cycles;
    }
    last = i;
}

static void translate(qemu_plugin_id_t id, struct qemu_plugin_tb *block)
{
    unsigned conditional = 0; /* instructions left of an IT block */
    (void)id;
    for (size_t n = 0; n < qemu_plugin_tb_n_insns(block); n++) {
        struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(block, n);
        uint32_t address = (uint32_t)qemu_plugin_insn_vaddr(insn);
        uint16_t code[2] = {0, 0};
        if (address - FLASH >= FLASH_BYTES)
            continue;
        struct instruction *i = &known[(address - FLASH) / 2];
        i->address = address;
        i->size = (uint32_t)qemu_plugin_insn_size(insn);
#if PLUGIN_VERSION < 3
        memcpy(code, qemu_plugin_insn_data(insn), i->size <= sizeof code ? i->size : sizeof code);
#else
        qemu_plugin_insn_data(insn, code, sizeof code);
#endif
        classify(i, code[0], code[1]);
        i->conditional |= conditional > 0; /* a block may begin within an IT block, so what was known stays */
        conditional -= conditional > 0;
        if ((code[0] & 0xFF00) == 0xBF00 && (code[0] & 0xF))
            conditional = 4 - (unsigned)__builtin_ctz(code[0] & 0xF);
        i->watched = -1;
        for (int w = 0; w < watched_count; w++)
            if (watched[w] == address)
                i->watched = w;
        qemu_plugin_register_vcpu_insn_exec_cb(insn, execute, QEMU_PLUGIN_CB_NO_REGS, i);
    }
}

__attribute__((visibility("default"))) int qemu_plugin_install(qemu_plugin_id_t id, const qemu_info_t *info, int count,
                                                               char **arguments)
{
    (void)info;
    for (int n = 0; n < count; n++) {
        if (strncmp(arguments[n], "watch=", 6) != 0 || watched_count == MOST_WATCHED) {
            fprintf(stderr, "counter: expected at most %d of watch=ADDRESS, found %s\n", MOST_WATCHED, arguments[n]);
            return -1;
        }
        watched[watched_count++] = (uint32_t)strtoul(arguments[n] + 6, NULL, 0);
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, translate);
    return 0;
}
