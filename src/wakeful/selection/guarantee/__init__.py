"""The guarantee on automatic processing: what it promises, what it rests on, and how it is kept."""

from wakeful.selection.guarantee.guarantee import Guarantee as Guarantee
from wakeful.selection.guarantee.guarantee import guarantee_of as guarantee_of
from wakeful.selection.guarantee.settings import GuaranteeSettings as GuaranteeSettings
