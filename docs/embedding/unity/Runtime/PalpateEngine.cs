// An opened asset and a contact on it, in native memory, of which the garbage collector knows
// nothing but when to free it. No Unity here: .NET programs take these two files alone. MIT licence.
using System;
using System.Runtime.InteropServices;

/// An opened .palp. Shared by any number of contacts and threads; freed with the last that uses it.
public sealed unsafe class PalpateEngine
{
    readonly IntPtr room;
    internal readonly Palpate.Asset* Asset;
    public readonly Palpate.Info Info;
    public readonly Palpate.Mesh Mesh;

    /// Throws ArgumentException, with the engine's sentence, on bytes that are no asset.
    public PalpateEngine(byte[] content)
    {
        Check(Palpate.HeaderFits());
        ulong size = (ulong)content.Length, roomBytes = size + 63;
        room = Marshal.AllocHGlobal((IntPtr)(sizeof(Palpate.Asset) + (long)roomBytes));
        Asset = (Palpate.Asset*)room;
        fixed (byte* bytes = content)
            Check(Palpate.palpate_open(Asset, Palpate.palpate_copy_aligned(Asset + 1, roomBytes, bytes, size), size));
        fixed (Palpate.Info* info = &Info) Palpate.palpate_describe(Asset, info);
        fixed (Palpate.Mesh* mesh = &Mesh) Palpate.palpate_read_mesh(Asset, mesh);
    }

    ~PalpateEngine() { Marshal.FreeHGlobal(room); }

    internal static void Check(int status)
    {
        if (status != Palpate.Ok) throw new ArgumentException(Palpate.Sentence(status));
    }
}

/// One tool on an asset, used by one thread at a time. Fill In, call Tick, read Out.
public sealed unsafe class PalpateContact
{
    readonly PalpateEngine engine;
    readonly Palpate.Contact* contact;
    readonly Palpate.Contact*[] copies = new Palpate.Contact*[3];
    readonly PalpateSlots slots = new PalpateSlots();
    public readonly Palpate.Input* In;
    public readonly Palpate.Output* Out;

    public PalpateContact(PalpateEngine engine, Palpate.Tool tool)
    {
        this.engine = engine;
        int bytes = 4 * sizeof(Palpate.Contact) + sizeof(Palpate.Input) + sizeof(Palpate.Output);
        contact = (Palpate.Contact*)Marshal.AllocHGlobal(bytes);
        for (byte* b = (byte*)contact; b < (byte*)contact + bytes; ++b) *b = 0;
        for (int i = 0; i < 3; ++i) copies[i] = contact + 1 + i;
        In = (Palpate.Input*)(contact + 4);
        Out = (Palpate.Output*)(In + 1);
        In->Tool.OrientationWxyz[0] = In->Body.OrientationWxyz[0] = 1;
        In->DtS = 0.001;
        PalpateEngine.Check(Palpate.palpate_start(contact, &tool));
    }

    ~PalpateContact() { Marshal.FreeHGlobal((IntPtr)contact); }

    /// 0, or a status whose Palpate.Sentence says what is wrong; there is no force then.
    public int Tick()
    {
        int status = Palpate.palpate_tick(engine.Asset, contact, In, Out);
        *copies[slots.Writing] = *contact; // 3 kB
        slots.Publish();
        GC.KeepAlive(this);
        return status;
    }

    /// As after a jump that was meant.
    public void Release()
    {
        Palpate.palpate_release(contact);
        GC.KeepAlive(this);
    }

    /// For the thread that draws, while another ticks: how far the tool has moved vertices `first` on
    /// [m], three floats each in the body's axes. False where the asset does not say, or nothing is new.
    public bool Deform(int first, int count, float[] displacementM)
    {
        if (displacementM.Length < 3 * count) throw new ArgumentException("room for 3 floats a vertex");
        if (!slots.Take()) return false;
        bool isThere;
        fixed (float* to = displacementM)
            isThere = Palpate.palpate_deform(engine.Asset, copies[slots.Reading], first, count, to) == Palpate.Ok;
        GC.KeepAlive(this);
        return isThere;
    }
}

/// Three slots between a thread that writes and one that reads: neither waits for the other.
public sealed class PalpateSlots
{
    const int Fresh = 4;
    int latest = 2;
    public int Writing { get; private set; }
    public int Reading { get; private set; }

    public PalpateSlots() { Reading = 1; }
    public void Publish() { Writing = System.Threading.Interlocked.Exchange(ref latest, Writing | Fresh) & 3; }
    /// Whether something new was published; it is in Reading then.
    public bool Take()
    {
        if ((System.Threading.Volatile.Read(ref latest) & Fresh) == 0) return false;
        Reading = System.Threading.Interlocked.Exchange(ref latest, Reading) & 3;
        return true;
    }
}
